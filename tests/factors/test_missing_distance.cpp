#include <gtest/gtest.h>

#include <holdfast/factors/missing_distance.hpp>
#include <holdfast/graph/variables.hpp>
#include <holdfast/testing.hpp>

#include "tests/conforms.hpp"

namespace holdfast {
namespace {

using Lifted = MissingDistanceBall<Point2, Point2>;
using Eliminated = MissingDistance<Point2, Point2>;

double lifted_cost(const Eliminated& factor, const Point2& a, const Point2& b, double omega) {
  const MissingDistancePrior prior{factor.d_prev, factor.rho};
  return 0.5 * prior(Scalar(omega)).squaredNorm() + 0.5 * Lifted{factor.sigma}(a, b, Scalar(omega)).squaredNorm();
}

TEST(MissingDistance, IsTheLeastLiftedCostAndReadsOmegaBack) {
  const Eliminated factor{4, 0.6, 0.8};
  const Point2 a(0, 0);
  for (const Point2& b : {Point2(1, 2), Point2(6, 8), Point2(0, 4.5)}) {
    const double omega = factor.estimate(a, b);
    const double cost = 0.5 * factor(a, b).squaredNorm();
    EXPECT_NEAR(lifted_cost(factor, a, b, omega), cost, 1e-13);
    for (const double off : {-1.0, -1e-3, 1e-3, 1.0}) EXPECT_GT(lifted_cost(factor, a, b, omega + off), cost);
  }
}

TEST(MissingDistance, InNumbers) {
  const Eliminated factor{4, 0.6, 0.8};  // √(σ² + ρ²) = 1
  EXPECT_NEAR(factor(Point2(0, 0), Point2(6, 8)).norm(), 6, 1e-14);
  EXPECT_NEAR(factor.estimate(Point2(0, 0), Point2(6, 8)), 4 + 0.64 * 6, 1e-14);
  EXPECT_EQ(factor(Point2(0, 0), Point2(1, 1)).norm(), 0);
  EXPECT_EQ(factor.estimate(Point2(0, 0), Point2(1, 1)), 4);
  EXPECT_DOUBLE_EQ((MissingDistancePrior{4, 0.5}(Scalar(5)))[0], 2);
  EXPECT_DOUBLE_EQ(Lifted{0.5}(Point2(0, 0), Point2(6, 8), Scalar(7))[0], 6);
}

TEST(MissingDistance, JacobiansAreExact) {
  std::mt19937_64 rng(1);
  using testing::jacobian_error;
  EXPECT_LT(jacobian_error(MissingDistancePrior{4, 0.5}, Scalar(1)), 1e-10);
  for (const double omega : {1.0, 50.0}) {
    const auto a = testing::random_variable<Pose2>(rng);
    const Motion2 b(a.p[0] + 3, 0, a.p[1] - 4, 0);
    EXPECT_LT(jacobian_error(MissingDistanceBall<Pose2, Motion2>{0.5}, a, b, Scalar(omega)), 1e-9);
    EXPECT_LT(jacobian_error(MissingDistance<Pose2, Motion2>{omega, 0.5, 0.5}, a, b), 1e-9);
  }
}

TEST(MissingDistance, HasNoSlopeWhereBothPositionsCoincide) {
  Jacobians<Lifted> J;
  J.all.setConstant(NAN);
  EXPECT_EQ(Lifted{0.5}(Point2(1, 1), Point2(1, 1), Scalar(-1), &J)[0], 2);
  EXPECT_TRUE((J.all.leftCols<4>().isZero(0)));
  EXPECT_EQ(J.all(0, 4), -2);  // Ω is pushed up, the positions are left alone
}

TEST(MissingDistance, RefusesNumbersThatAreNone) {
  EXPECT_THROW((MissingDistancePrior{-1, 1}).validate(), BadNumber);
  EXPECT_THROW((MissingDistancePrior{1, 0}).validate(), BadNumber);
  EXPECT_THROW((Lifted{NAN}).validate(), BadNumber);
  EXPECT_THROW((Eliminated{NAN, 1, 1}).validate(), BadNumber);
  EXPECT_THROW((Eliminated{1, 0, 1}).validate(), BadNumber);
  EXPECT_THROW((Eliminated{1, 1, INFINITY}).validate(), BadNumber);
}

TEST(MissingDistance, RawIsTheExcessInMetres) {
  const Eliminated factor{3, 0.3, 0.4};
  EXPECT_NEAR(factor.raw(factor({0, 0}, {3, 4})).norm(), 2, 1e-15);
}

}  // namespace
}  // namespace holdfast

namespace holdfast::testing {

template <class A, class B>
struct Sample<MissingDistance<A, B>> : RandomVariables<MissingDistance<A, B>> {
  static MissingDistance<A, B> factor(std::mt19937_64& rng) { return {radius(rng), uniform(rng, 0.5, 2), uniform(rng, 0.5, 2)}; }
};

template <>
struct Sample<MissingDistancePrior> : RandomVariables<MissingDistancePrior> {
  static MissingDistancePrior factor(std::mt19937_64& rng) { return {uniform(rng, 0, 20), uniform(rng, 0.5, 2)}; }
};

template <class A, class B>
struct Sample<MissingDistanceBall<A, B>> : RandomVariables<MissingDistanceBall<A, B>> {
  static MissingDistanceBall<A, B> factor(std::mt19937_64& rng) { return {uniform(rng, 0.5, 2)}; }
  /// The third variable is the radius of the ball.
  static std::tuple<A, B, Scalar> variables(std::mt19937_64& rng) {
    return std::tuple_cat(RandomVariables<MissingDistance<A, B>>::variables(rng), std::tuple<Scalar>(radius(rng)));
  }
};

}  // namespace holdfast::testing

HOLDFAST_CONFORMS(MissingDistancePrior, OnSomePairs<MissingDistance>, OnSomePairs<MissingDistanceBall>);
