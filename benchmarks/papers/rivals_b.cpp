#include <Eigen/LU>
#include <holdfast/benchmarks/papers/rivals_b.hpp>
#include <holdfast/factors/constant_turn.hpp>

namespace holdfast::bench {
namespace {

const Matrix<2, 4> kH = Motion2::position_jacobian();

Matrix<4, 4> turn(double omega) { return ConstantTurn<Motion2>{kFlightStep, omega, Matrix<4, 4>::Identity()}.transition(); }

}  // namespace

ImmB::ImmB(const FilterBOptions& options, const Motion2& state)
    : options_(options),
      Q_(options.q * Matrix<4, 4>::Identity()),
      R_(options.R * Matrix<2, 2>::Identity()),
      W_(Matrix<2, 2>::Identity() / std::sqrt(options.R)) {
  constexpr double kRate = 2 * kPi / 180;  // [rad/s]
  F_ = {turn(0), turn(kRate), turn(-kRate)};
  filters_.transition << 0.4, 0.3, 0.3, 0.3, 0.4, 0.3, 0.3, 0.3, 0.4;
  filters_.probabilities << 0.4, 0.3, 0.3;
  filters_.models.fill({state.value, 0.1 * Matrix<4, 4>::Identity()});
}

void ImmB::step(const Vector<2>& gps) {
  filters_.step([&](int i, const Gaussian<4>& before) { return filtered(before, F_[i], gps); });
}

Filtered<4> ImmB::filtered(const Gaussian<4>& before, const Matrix<4, 4>& F, const Vector<2>& gps) {
  if (options_.kind == FilterB::arkf) return corrected_adaptively(before, F, gps);
  const Gaussian<4> prior = predicted(before, F, Q_);
  if (options_.kind == FilterB::ekf) return corrected_by_range_and_bearing(prior, gps);
  const Innovation<2> innovation{gps - kH * prior.mean, innovation_covariance(prior.covariance, kH, R_)};
  return {corrected(prior, innovation, kH, R_), innovation.log_likelihood()};
}

Filtered<4> ImmB::corrected_by_range_and_bearing(const Gaussian<4>& prior, const Vector<2>& gps) const {
  const double x = prior.mean[0], y = prior.mean[2], range = std::max(std::hypot(x, y), kZeroDistance);
  Matrix<2, 4> H = Matrix<2, 4>::Zero();
  H(0, 0) = x / range;
  H(0, 2) = y / range;
  H(1, 0) = -y / (range * range);
  H(1, 2) = x / (range * range);
  const Vector<2> r(gps.norm() - range, wrap_angle(std::atan2(gps[1], gps[0]) - std::atan2(y, x)));
  const Innovation<2> innovation{r, innovation_covariance(prior.covariance, H, R_)};
  return {corrected(prior, innovation, H, R_), innovation.log_likelihood()};
}

Matrix<2, 2> adapted_covariance(const Vector<2>& r, const Matrix<2, 2>& W) {
  constexpr double h = 0.15, sigma1 = 2, sigma2 = 8;
  const Vector<2> e = W * r;
  const auto kernel = [](double distance, double sigma) { return std::max(1e-9, std::exp(-distance * distance / (2 * sigma * sigma))); };
  const double theta = kernel(e[0] - e[1], sigma2);  // (24) off the diagonal; its diagonal cancels in N
  Matrix<2, 2> N, M = Matrix<2, 2>::Zero();
  N << theta, -theta, -theta, theta;
  for (int i = 0; i < 2; ++i) M(i, i) = kernel(e[i], sigma1);
  const Matrix<2, 2> Gamma = h / (sigma1 * sigma1) * M + 2 * (1 - h) / (sigma2 * sigma2) * N;
  return Matrix<2, 2>(W * Gamma * W).inverse();
}

Filtered<4> ImmB::corrected_adaptively(const Gaussian<4>& before, const Matrix<4, 4>& F, const Vector<2>& gps) {
  constexpr double kChiSquare = 5.991;  // 2 degrees of freedom, 95 %
  constexpr int kMostSteps = 20;
  const Matrix<4, 4> moved = F * before.covariance * F.transpose();
  Gaussian<4> prior{F * before.mean, moved + Q_};
  Innovation<2> innovation{gps - kH * prior.mean, {}};
  const Matrix<2, 2> R = adapted_covariance(innovation.r, W_);
  innovation.S = innovation_covariance(prior.covariance, kH, R);
  double lambda = 1, squared = innovation.normalized_squared();
  if (squared > kChiSquare) ++alarms_;
  for (int i = 0; i < kMostSteps && squared > kChiSquare; ++i) {
    const Vector<2> u = innovation.S.llt().solve(innovation.r);
    lambda += (squared - kChiSquare) / u.dot(kH * moved * kH.transpose() * u);
    prior.covariance = lambda * moved + Q_;
    innovation.S = innovation_covariance(prior.covariance, kH, R);
    squared = innovation.normalized_squared();
  }
  return {corrected(prior, innovation, kH, R), innovation.log_likelihood()};
}

}  // namespace holdfast::bench
