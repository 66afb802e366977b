#include <gtest/gtest.h>

#include <holdfast/solvers/irls/internal/line_search.hpp>

#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

using holdfast::detail::minimize_along;
using holdfast::detail::Phi;
using holdfast::detail::phi_of_rows;
using holdfast::detail::weights_of_rows;

/// A batch of priors under a loss, its residuals at a point and their change along a direction.
struct Line {
  Graph graph;
  std::vector<double> r, Jd, weights;

  explicit Line(const Loss& loss) {
    std::mt19937_64 rng(3);
    for (int i = 0; i < 20; ++i) {
      graph.add(Prior<Point3>::from_sigmas(Point3(0, 0, 0), Vector<3>(1, 1, 1)), {Key('A', i)}, loss, uniform(rng, 0, 3));
      for (int c = 0; c < 3; ++c) {
        r.push_back(uniform(rng, -5, 5));
        Jd.push_back(uniform(rng, -5, 5));
      }
    }
    weights.resize(r.size());
    weights_of_rows(*graph.batches()[0], weights.data());
  }
  Phi at(double alpha) const {
    return phi_of_rows(graph.batches()[0]->family(), static_cast<int>(r.size()), 3, weights.data(), r.data(), Jd.data(), alpha);
  }
  double cost(double alpha) const {
    double sum = 0;
    for (int i = 0; i < 20; ++i) {
      Eigen::VectorXd x(3);
      for (int c = 0; c < 3; ++c) x[c] = r[3 * i + c] + alpha * Jd[3 * i + c];
      sum += reference_term(graph.batches()[0]->family(), graph.batches()[0]->weight(i), x).cost;
    }
    return sum;
  }
};

TEST(Phi, IsTheCostAlongTheLine) {
  for (const Loss& loss : every_loss(3)) {
    const Line line(loss);
    for (const double alpha : {0.0, 0.3, 1.0, 4.0})
      EXPECT_NEAR(line.at(alpha).value, line.cost(alpha), 1e-12 * line.cost(alpha)) << loss.str();
  }
}

TEST(Phi, DerivativesAreThoseOfTheCost) {
  constexpr double h = 1e-6;
  for (Loss loss : every_loss(3)) {
    if (loss.kind == Loss::Kind::Absolute) loss.scale = 0.5;  // wide against the step of the differences
    const Line line(loss);
    for (const double alpha : {0.1, 0.7, 2.0}) {
      const Phi phi = line.at(alpha);
      EXPECT_NEAR(phi.slope, (line.at(alpha + h).value - line.at(alpha - h).value) / (2 * h), 1e-6 * (1 + std::abs(phi.slope)))
          << loss.str();
      EXPECT_NEAR(phi.curvature, (line.at(alpha + h).slope - line.at(alpha - h).slope) / (2 * h), 1e-4 * (1 + std::abs(phi.curvature)))
          << loss.str();
    }
  }
}

TEST(MinimizeAlong, FindsTheMinimumOfAParabolaAnywhere) {
  for (const double at : {1e-4, 0.1, 0.9, 1.0, 5.0, 300.0}) {
    const auto parabola = [&](double a) { return Phi{(a - at) * (a - at), 2 * (a - at), 2}; };
    EXPECT_NEAR(minimize_along(parabola(0), 1e-6, parabola), at, 1e-5 * at);
  }
}

// Beyond α = 1e-5 the slope has saturated, as under Huber along a direction that the model takes for flat.
TEST(MinimizeAlong, ComesBackFromFarOutInAFewSteps) {
  int evaluations = 0;
  const auto kink = [&](double a) {
    ++evaluations;
    const double x = (a - 1e-5) * 1e6;
    return Phi{std::sqrt(1 + x * x), 1e6 * x / std::sqrt(1 + x * x), 1e12 / std::pow(1 + x * x, 1.5)};
  };
  const Phi start = kink(0);
  evaluations = 0;
  EXPECT_NEAR(minimize_along(start, 0.1, kink), 1e-5, 1e-6);
  EXPECT_LE(evaluations, 8);
}

// Next to the minimum the value has no more digits (here it is even a bit higher there); the slope has.
TEST(MinimizeAlong, BelievesTheSlopeWhereValuesDifferByRoundingOnly) {
  const auto parabola = [](double a) { return Phi{1000 + 1e-13 * a, 1e-9 * (a - 1), 1e-9}; };
  EXPECT_NEAR(minimize_along(parabola(0), 0.3, parabola), 1, 0.3);
}

TEST(MinimizeAlong, NeverGoesUp) {
  for (const Loss& loss : every_loss(3)) {
    Line line(loss);
    if (line.at(0).slope > 0)
      for (double& d : line.Jd) d = -d;
    const double alpha = minimize_along(line.at(0), 1e-2, [&](double a) { return line.at(a); });
    EXPECT_GE(alpha, 0) << loss.str();
    EXPECT_LE(line.at(alpha).value, line.at(0).value) << loss.str();
  }
}

}  // namespace
}  // namespace holdfast::testing
