#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <holdfast/program/sought.hpp>
#include <limits>

namespace holdfast::program {
namespace {

constexpr double kMargin = 6, kKnee = 2;
constexpr std::size_t kFewest = 4;
constexpr int kIterations = 60;

struct Problem {
  const std::vector<Sight>& sights;
  const std::optional<Guess>& guess;
  int dim;
};

struct Found {
  Vector<3> place;
  double cost;
  Matrix<3, 3> information;
};

/// Cost, gradient and JᵀJ with the weights of the loss.
struct Model {
  double cost = 0;
  Vector<3> gradient = Vector<3>::Zero();
  Matrix<3, 3> information = Matrix<3, 3>::Zero();

  Model(const Problem& problem, const Vector<3>& x) {
    for (const Sight& sight : problem.sights) {
      const Vector<3> apart = x - sight.from;
      const double n = apart.norm(), r = (n - sight.distance) / sight.sigma, u = r * r / (kKnee * kKnee);
      cost += 0.5 * kKnee * kKnee * std::log1p(u);
      if (n < kZeroDistance) continue;
      const Vector<3> J = apart / (n * sight.sigma);
      gradient += J * (r / (1 + u));
      information += J * J.transpose() / (1 + u);
    }
    if (problem.guess) {
      const double w = 1 / (problem.guess->sigma * problem.guess->sigma);
      cost += 0.5 * w * (x - problem.guess->place).squaredNorm();
      gradient += w * (x - problem.guess->place);
      information += w * Matrix<3, 3>::Identity();
    }
    if (problem.dim == 2) {  // z is not sought
      gradient[2] = 0;
      information.row(2).setZero();
      information.col(2).setZero();
      information(2, 2) = 1;
    }
  }
};

/// Levenberg–Marquardt.
Found descend(const Problem& problem, Vector<3> x) {
  Model model(problem, x);
  double damping = 1e-3;
  for (int i = 0; i < kIterations && damping < 1e9; ++i) {
    Matrix<3, 3> H = model.information;
    H.diagonal() *= 1 + damping;
    H.diagonal().array() += 1e-12;
    const Vector<3> step = -H.ldlt().solve(model.gradient);
    const Model next(problem, x + step);
    if (!(next.cost <= model.cost)) {
      damping *= 4;
      continue;
    }
    const bool arrived = model.cost - next.cost <= 1e-10 * (1 + model.cost);
    x += step;
    model = next;
    damping *= 0.3;
    if (arrived) break;
  }
  return {x, model.cost, model.information};
}

std::vector<Vector<3>> directions(int dim) {
  std::vector<Vector<3>> all;
  if (dim == 2) {
    for (int k = 0; k < 12; ++k) all.emplace_back(std::cos(k * kPi / 6), std::sin(k * kPi / 6), 0);
    return all;
  }
  for (int x : {-1, 0, 1})
    for (int y : {-1, 0, 1})
      for (int z : {-1, 0, 1})
        if (x != 0 || y != 0 || z != 0) all.push_back(Vector<3>(x, y, z).normalized());
  return all;
}

/// Median of the squared residuals over what it is for a normal distribution; at least 1.
double squared_scale(const std::vector<Sight>& sights, const Vector<3>& place) {
  std::vector<double> squares;
  for (const Sight& sight : sights) {
    const double r = ((place - sight.from).norm() - sight.distance) / sight.sigma;
    squares.push_back(r * r);
  }
  const auto middle = squares.begin() + static_cast<std::ptrdiff_t>(squares.size() / 2);
  std::nth_element(squares.begin(), middle, squares.end());
  return std::max(1.0, *middle / 0.4549);
}

}  // namespace

std::optional<Vector<3>> located(const std::vector<Sight>& sights, const std::optional<Guess>& guess, int dim) {
  if (sights.size() < kFewest) return std::nullopt;
  const Problem problem{sights, guess, dim};
  const auto nearest =
      std::min_element(sights.begin(), sights.end(), [](const Sight& a, const Sight& b) { return a.distance < b.distance; });
  std::vector<Found> all;
  for (const Sight* round : {&*nearest, &sights.front(), &sights.back()})
    for (const Vector<3>& direction : directions(dim)) all.push_back(descend(problem, round->from + round->distance * direction));
  if (guess) all.push_back(descend(problem, guess->place));
  const Found best = *std::min_element(all.begin(), all.end(), [](const Found& a, const Found& b) { return a.cost < b.cost; });

  const double scale = squared_scale(sights, best.place);
  const double least = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(best.information.topLeftCorner(dim, dim)).eigenvalues()[0];
  const double deviation = least > 0 ? std::sqrt(scale / least) : std::numeric_limits<double>::infinity();
  if (!(4 * deviation <= std::max(nearest->distance, nearest->sigma))) return std::nullopt;
  const bool settled = std::all_of(all.begin(), all.end(), [&](const Found& other) {
    const bool is_another = (other.place - best.place).norm() > std::max(4 * deviation, 1e-3);
    return !is_another || other.cost - best.cost >= kMargin * scale;
  });
  if (!settled) return std::nullopt;
  return best.place;
}

}  // namespace holdfast::program
