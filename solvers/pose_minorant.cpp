#include <Eigen/Eigenvalues>
#include <holdfast/solvers/internal/pose_minorant.hpp>

namespace holdfast::detail {
namespace {

constexpr double kNegligible = 1e-12;  // of the diagonal blocks: a cross block as small as that is rounding

template <int N>
double least_eigenvalue(const Matrix<N, N>& S) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, N, N>>(S, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

/// 1 − ρ: Λ ≥ (1 − ρ) diag(Λ_tt, Λ_rr).
template <int N, int n>
double uncorrelated(const Matrix<N, N>& L) {
  constexpr int m = N - n;
  const Matrix<n, m> C = L.template topRightCorner<n, m>();
  if (C.cwiseAbs().maxCoeff() <= kNegligible * L.diagonal().cwiseAbs().maxCoeff()) return 1;
  const Eigen::LLT<Eigen::Matrix<double, n, n>> t(L.template topLeftCorner<n, n>());
  const Eigen::LLT<Eigen::Matrix<double, m, m>> r(L.template bottomRightCorner<m, m>());
  if (t.info() != Eigen::Success || r.info() != Eigen::Success) return 0;
  const Eigen::Matrix<double, n, m> left = t.matrixL().solve(Eigen::Matrix<double, n, m>(C));
  const Eigen::Matrix<double, m, n> both = r.matrixL().solve(Eigen::Matrix<double, m, n>(left.transpose()));
  const Eigen::Matrix<double, m, m> squares = both * both.transpose();
  const double rho2 = Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, m, m>>(squares, Eigen::EigenvaluesOnly).eigenvalues()[m - 1];
  return std::max(0.0, 1 - std::sqrt(std::max(0.0, rho2)));
}

/// Adds terms to a minorant.
template <class Pose>
class Builder {
 public:
  static constexpr int n = Pose::space_dim, N = Pose::dim, m = N - n;
  static constexpr int Ra = 0, pa = n, Rb = n + 1, pb = 2 * n + 1;
  using Square = Matrix<n, n>;

  explicit Builder(const Pose& measured) : measured_(measured), Rz_(measured.rotation()) {}

  /// ½τ‖y‖²
  void add_distance(double tau) {
    Vector<2 * n + 2> c;
    c << -measured_.p, -1, Vector<n>::Zero(), 1;
    form_.K += tau * c * c.transpose();
  }
  /// ⟨l, y⟩
  void add_linear(const Vector<n>& l) {
    for (int k = 0; k < n; ++k) {
      put(Ra + k, pb, l[k]);
      put(Ra + k, pa, -l[k]);
    }
    form_.constant -= l.dot(measured_.p);
  }
  /// −½⟨M, E⟩
  void add_rotation(const Square& M) {
    const Square G = -0.5 * Rz_ * M;
    for (int k = 0; k < n; ++k)
      for (int l = 0; l < n; ++l) put(Ra + k, Rb + l, G(k, l));
  }
  /// κ(1 − cos θ)
  void add_chord(double kappa) {
    add_rotation(kappa * Square::Identity());
    form_.constant += n == 2 ? kappa : 1.5 * kappa;  // tr E = 2 cos θ, 1 + 2 cos θ
  }
  void add_constant(double c) { form_.constant += c; }
  const PoseMinorant<Pose>& form() const { return form_; }

 private:
  void put(int row, int column, double value) {
    form_.K(row, column) += value;
    form_.K(column, row) += value;
  }
  const Pose& measured_;
  Square Rz_;
  PoseMinorant<Pose> form_;
};

/// The c of ⟨g, φ⟩.
double bend_of_angle(double theta0) {
  const double x = kPi + theta0;
  return 1.05 * (x - std::sin(x)) / (1 - std::cos(x));
}

/// ½ω θ² + g θ in the plane.
void add_turn(Builder<Pose2>& builder, const Matrix<1, 1>& information, const Vector<1>& g, const Vector<1>& phi) {
  constexpr double kLargest = 3;  // [rad]
  const double kappa = information(0, 0), t0 = phi[0], size = std::abs(t0);
  if (size > kLargest) {
    builder.add_chord(kappa);
    builder.add_constant(-kPi * std::abs(g[0]));
    return;
  }
  const double cot = size < 1e-4 ? 1 - t0 * t0 / 3 : t0 / std::tan(t0);
  const double A = kappa * cot - bend_of_angle(size) * std::abs(g[0]), slope = kappa * t0 + g[0];
  Matrix<2, 2> E0, in_delta;
  E0 << std::cos(t0), -std::sin(t0), std::sin(t0), std::cos(t0);
  in_delta << A, slope, -slope, A;  // A I − slope J
  builder.add_rotation(E0 * in_delta);
  builder.add_constant(0.5 * kappa * t0 * t0 + g[0] * t0 + A);
}

/// s of ψ(φ) = φᵀΩφ s(θ), and s'(θ)/θ.
std::pair<double, double> rest_of_chord(double theta) {
  const double t2 = theta * theta;
  if (theta < 1e-2) return {t2 / 24 - t2 * t2 / 720, 1.0 / 12 - t2 / 180};
  const double versine = 1 - std::cos(theta);
  return {0.5 - versine / t2, (2 * versine / theta - std::sin(theta)) / (t2 * theta)};
}

/// ½φᵀΩφ + ⟨g, φ⟩ in space.
void add_turn(Builder<Pose3>& builder, const Matrix<3, 3>& information, const Vector<3>& g, const Vector<3>& phi) {
  constexpr double kLargest = 1.5;  // [rad]
  const Matrix<3, 3> I = Matrix<3, 3>::Identity();
  const double kappa = std::max(0.0, least_eigenvalue<3>(information));
  const Matrix<3, 3> rest = information - kappa * I;
  const double trace = std::max(0.0, rest.trace()), theta0 = phi.norm();
  builder.add_rotation(trace * I - 2 * rest);  // tr A(I − E), A = ½ tr(Ω) I − Ω
  builder.add_constant(0.5 * trace);
  if (theta0 > kLargest) {
    builder.add_chord(kappa);
    builder.add_constant(-kPi * g.norm());
    return;
  }
  const double ratio = theta0 < 1e-4 ? 1 + theta0 * theta0 / 6 : theta0 / std::sin(theta0);
  builder.add_chord(kappa * ratio);
  builder.add_constant(0.5 * kappa * theta0 * theta0 - kappa * ratio * (1 - std::cos(theta0)));

  const auto [s, slope] = rest_of_chord(theta0);
  const Vector<3> in_rest = rest * phi;
  const double square = phi.dot(in_rest);
  const double bend = 0.016 * theta0 * theta0 * (1 + theta0 * theta0) * trace + bend_of_angle(theta0) * g.norm();
  const Vector<3> v = so3::right_jacobian_inverse(phi).transpose() * (2 * s * in_rest + square * slope * phi + g);
  const Matrix<3, 3> E0 = so3::exp<double>(phi).toRotationMatrix();
  builder.add_rotation(-E0 * so3::hat(v) - bend * E0);
  builder.add_constant(square * s + g.dot(phi) - 1.5 * bend);
}

Vector<3> error_of(const Pose2& z, const Pose2& a, const Pose2& b) {
  const Pose2 e = z.inverse() * (a.inverse() * b);
  return {e.p[0], e.p[1], e.angle()};
}
Vector<6> error_of(const Pose3& z, const Pose3& a, const Pose3& b) {
  const Pose3 e = z.inverse() * (a.inverse() * b);
  Vector<6> error;
  error << e.p, so3::log<double>(e.q);
  return error;
}

/// The harmonic mean of the eigenvalues; 0 where one of them is.
template <int n>
double harmonic_mean(const Matrix<n, n>& S) {
  const auto values = Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, n, n>>(S, Eigen::EigenvaluesOnly).eigenvalues().eval();
  if (!(values[0] > kNegligible * values[n - 1])) return 0;
  return n / values.cwiseInverse().sum();
}

}  // namespace

template <class Pose>
PoseMinorant<Pose> minorant_at(const MeasuredPose<Pose>& measured, double weight, const Pose& a, const Pose& b) {
  using B = Builder<Pose>;
  constexpr int n = B::n, m = B::m, N = B::N;
  const Matrix<N, N> L = weight * measured.information;
  const double part = uncorrelated<N, n>(L);
  const double tau = std::max(0.0, part * least_eigenvalue<n>(L.template topLeftCorner<n, n>()));
  const Matrix<m, m> in_rotation = part * L.template bottomRightCorner<m, m>();
  Matrix<N, N> rest = L;
  rest.template topLeftCorner<n, n>() -= tau * Matrix<n, n>::Identity();
  rest.template bottomRightCorner<m, m>() -= in_rotation;
  const Vector<N> e = error_of(measured.pose, a, b);
  const Vector<N> pull = rest * e;

  B builder(measured.pose);
  builder.add_distance(tau);
  builder.add_linear(measured.pose.rotation() * pull.template head<n>());
  builder.add_constant(-0.5 * e.dot(pull));
  add_turn(builder, in_rotation, pull.template tail<m>(), e.template tail<m>());
  return builder.form();
}

template <class Pose>
PoseMinorant<Pose> chordal_form(const MeasuredPose<Pose>& measured, double weight) {
  using B = Builder<Pose>;
  B builder(measured.pose);
  builder.add_distance(weight * harmonic_mean<B::n>(measured.information.template topLeftCorner<B::n, B::n>()));
  builder.add_chord(weight * harmonic_mean<B::m>(measured.information.template bottomRightCorner<B::m, B::m>()));
  return builder.form();
}

template <class Pose>
PoseMinorant<Pose> chordal_form_below(const MeasuredPose<Pose>& measured, double weight) {
  using B = Builder<Pose>;
  const double part = weight * uncorrelated<B::N, B::n>(measured.information);
  B builder(measured.pose);
  builder.add_distance(std::max(0.0, part * least_eigenvalue<B::n>(measured.information.template topLeftCorner<B::n, B::n>())));
  builder.add_chord(std::max(0.0, part * least_eigenvalue<B::m>(measured.information.template bottomRightCorner<B::m, B::m>())));
  return builder.form();
}

template <class Pose>
bool is_isotropic(const Matrix<Pose::dim, Pose::dim>& information) {
  constexpr int n = Pose::space_dim, m = Pose::dim - n;
  Matrix<Pose::dim, Pose::dim> isotropic = Matrix<Pose::dim, Pose::dim>::Zero();
  isotropic.diagonal().template head<n>().setConstant(information(0, 0));
  isotropic.diagonal().template tail<m>().setConstant(information(n, n));
  return (information - isotropic).cwiseAbs().maxCoeff() <= 1e-9 * information.cwiseAbs().maxCoeff();
}

template PoseMinorant<Pose2> minorant_at(const MeasuredPose<Pose2>&, double, const Pose2&, const Pose2&);
template PoseMinorant<Pose3> minorant_at(const MeasuredPose<Pose3>&, double, const Pose3&, const Pose3&);
template PoseMinorant<Pose2> chordal_form(const MeasuredPose<Pose2>&, double);
template PoseMinorant<Pose3> chordal_form(const MeasuredPose<Pose3>&, double);
template PoseMinorant<Pose2> chordal_form_below(const MeasuredPose<Pose2>&, double);
template PoseMinorant<Pose3> chordal_form_below(const MeasuredPose<Pose3>&, double);
template bool is_isotropic<Pose2>(const Matrix<3, 3>&);
template bool is_isotropic<Pose3>(const Matrix<6, 6>&);

}  // namespace holdfast::detail
