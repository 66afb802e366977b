// The dogleg against dense linear algebra: H, g and D = diag H of a small problem.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <holdfast/factors/between.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/solvers/irls/internal/dogleg.hpp>
#include <holdfast/solvers/irls/internal/newton_system.hpp>

namespace holdfast::testing {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using holdfast::detail::Dogleg;
using holdfast::detail::NewtonSystem;
using holdfast::detail::TrustRegion;

constexpr Agent A('A');

Graph tied_points(bool with_priors) {
  Graph graph;
  if (with_priors) graph.add(Prior<Point2>::from_sigmas(Point2(1, 2), Vector<2>(1, 0.2)), {A(0)});
  if (with_priors) graph.add(Prior<Point2>::from_sigmas(Point2(-3, 0), Vector<2>(2, 1)), {A(1)});
  graph.add(Between<Point2>::from_sigmas(Point2(1, 1), Vector<2>(0.3, 0.6)), {A(0), A(1)});
  graph.add(Between<Point2>::from_sigmas(Point2(5, 1), Vector<2>(0.5, 0.5)), {A(1), A(2)});
  if (with_priors) graph.add(Prior<Point2>::from_sigmas(Point2(4, 4), Vector<2>(3, 3)), {A(2)});
  return graph;
}
Values points() {
  Values values;
  values.insert(A(0), Point2(7, -4));
  values.insert(A(1), Point2(-5, 8));
  values.insert(A(2), Point2(0, 9));
  return values;
}

class DoglegTest : public ::testing::Test {
 protected:
  DoglegTest() : graph(tied_points(true)), values(points()), system(graph, values, 1), dogleg(system) {
    system.linearize(graph, values, Curvature::irls);
    const int n = static_cast<int>(system.size());
    H.resize(n, n);
    std::vector<double> unit(n), column(n);
    for (int c = 0; c < n; ++c) {
      unit.assign(n, 0.0);
      unit[c] = 1;
      system.multiply(unit, column);
      H.col(c) = Eigen::Map<VectorXd>(column.data(), n);
    }
    g = Eigen::Map<const VectorXd>(system.gradient().data(), n);
    D = H.diagonal();
    newton = -H.ldlt().solve(g);
    const VectorXd steepest = -g.cwiseQuotient(D);
    cauchy = -g.dot(steepest) / steepest.dot(H * steepest) * steepest;
    EXPECT_TRUE(dogleg.begin(system));
  }
  double length(const VectorXd& p) const { return std::sqrt(p.dot(D.cwiseProduct(p))); }
  double decrease(const VectorXd& p) const { return -g.dot(p) - 0.5 * p.dot(H * p); }
  VectorXd take(double radius) {
    std::vector<double> p(system.size());
    step = dogleg.take(system, radius, p);
    return Eigen::Map<VectorXd>(p.data(), static_cast<int>(p.size()));
  }

  Graph graph;
  Values values;
  NewtonSystem system;
  Dogleg dogleg;
  MatrixXd H;
  VectorXd g, D, newton, cauchy;
  Dogleg::Step step{};
};

TEST_F(DoglegTest, TheProblemHasAllThreePartsOfThePath) {
  EXPECT_LT(length(cauchy), 0.99 * length(newton));
  EXPECT_GT(length(cauchy), 0.1 * length(newton));
}

TEST_F(DoglegTest, WithinTheRadiusIsNewtonsStep) {
  for (const double radius : {std::numeric_limits<double>::infinity(), 1.001 * length(newton)}) {
    EXPECT_LT((take(radius) - newton).norm(), 1e-10 * newton.norm());
    EXPECT_NEAR(step.predicted, decrease(newton), 1e-10 * step.predicted);
    EXPECT_NEAR(step.length, length(newton), 1e-10 * step.length);
    EXPECT_TRUE(step.is_full);
  }
}

TEST_F(DoglegTest, WithASmallRadiusIsAlongTheSteepestDescent) {
  for (const double part : {0.01, 0.5, 0.999}) {
    EXPECT_LT((take(part * length(cauchy)) - part * cauchy).norm(), 1e-10 * cauchy.norm()) << part;
    EXPECT_NEAR(step.predicted, decrease(part * cauchy), 1e-10 * step.predicted);
    EXPECT_NEAR(step.length, part * length(cauchy), 1e-10 * step.length);
  }
}

TEST_F(DoglegTest, TurnsAtTheMinimumAlongTheSteepestDescent) {
  EXPECT_LT((take(length(cauchy)) - cauchy).norm(), 1e-9 * cauchy.norm());
  EXPECT_GT(step.predicted, decrease(0.99 * cauchy));
  EXPECT_GT(step.predicted, decrease(1.01 * cauchy));
}

TEST_F(DoglegTest, BeyondItIsOnTheWayToNewtonsStepAtTheRadius) {
  for (const double part : {0.1, 0.5, 0.9}) {
    const double radius = (1 - part) * length(cauchy) + part * length(newton);
    const VectorXd p = take(radius);
    EXPECT_NEAR(length(p), radius, 1e-10 * radius);
    EXPECT_NEAR(step.length, radius, 1e-10 * radius);
    EXPECT_NEAR(step.predicted, decrease(p), 1e-10 * step.predicted);
    const VectorXd way = newton - cauchy, gone = p - cauchy;
    const double b = gone.dot(way) / way.squaredNorm();
    EXPECT_GT(b, 0);
    EXPECT_LT(b, 1);
    EXPECT_LT((gone - b * way).norm(), 1e-10 * way.norm());
  }
}

TEST_F(DoglegTest, IsFullFromATenthOfNewtonsStepOn) {
  take(0.1001 * length(newton));
  EXPECT_TRUE(step.is_full);
  take(0.0999 * length(newton));
  EXPECT_FALSE(step.is_full);
}

// Nothing says where the three points are together: H is singular, and the least damping makes a step of what is known.
TEST(Dogleg, OfASingularProblemIsDampedLittle) {
  const Graph graph = tied_points(false);
  const Values values = points();
  NewtonSystem system(graph, values, 1);
  Dogleg dogleg(system);
  const double cost = system.linearize(graph, values, Curvature::irls);
  ASSERT_TRUE(dogleg.begin(system));
  std::vector<double> p(system.size());
  EXPECT_NEAR(dogleg.take(system, 1e9, p).predicted, cost, 1e-6 * cost);  // two steps between three points: satisfied exactly
}

TEST(TrustRegion, IsOpenAtFirstAndFollowsTheGain) {
  TrustRegion region;
  EXPECT_TRUE(std::isinf(region.radius()));
  region.accept(0.2, 4);  // far less than the model said
  EXPECT_EQ(region.radius(), 2);
  region.accept(0.5, 2);  // neither good nor bad
  EXPECT_EQ(region.radius(), 2);
  region.accept(0.9, 1);  // good, but shorter than a third of the radius
  EXPECT_EQ(region.radius(), 3);
  region.accept(0.9, 0.1);
  EXPECT_EQ(region.radius(), 3);
  region.reject(1);
  EXPECT_EQ(region.radius(), 0.5);
}

}  // namespace
}  // namespace holdfast::testing
