#include <gtest/gtest.h>

#include <holdfast/factors/range_ball.hpp>
#include <holdfast/graph/variables.hpp>
#include <holdfast/testing.hpp>

#include "tests/conforms.hpp"

namespace holdfast {
namespace {

using Ball = RangeBall<Pose2, Point2>;

TEST(RangeBall, IsTheWayToTheBallInSigmas) {
  EXPECT_TRUE((Ball{3, 0.5}(Pose2(1, 1, 2), Point2(4, 5))).isApprox(Vector<2>(2.4, 3.2), 1e-15));  // 2 m outside
  EXPECT_TRUE((Ball{6, 0.5}(Pose2(1, 1, 2), Point2(4, 5))).isZero(0));
  EXPECT_TRUE((Ball{5, 0.5}(Pose2(1, 1, 2), Point2(4, 5))).isZero(0));
}

TEST(RangeBall, PullsOutsideAndNotInside) {
  Jacobians<Ball> J;
  J.all.setConstant(NAN);
  Ball{6, 0.5}(Pose2(1, 1, 2), Point2(4, 5), &J);
  EXPECT_TRUE(J.all.isZero(0));
  Ball{3, 0.5}(Pose2(1, 1, 2), Point2(4, 5), &J);
  const Vector<2> along(0.6, 0.8), across(-0.8, 0.6);
  EXPECT_TRUE((J.wrt<1>() * along).isApprox(2 * along, 1e-15));
  EXPECT_TRUE((J.wrt<1>() * across).isApprox(2 * 0.4 * across, 1e-15));  // 2 m of 5 m outside
  EXPECT_EQ(J.wrt<0>().leftCols<2>(), -J.wrt<1>());
  EXPECT_LT(testing::jacobian_error(Ball{3, 0.5}, Pose2(1, 1, 2), Point2(4, 5)), 1e-10);
}

TEST(RangeBall, OfRadiusZeroIsFiniteWherePositionsCoincide) {
  Jacobians<Ball> J;
  J.all.setConstant(NAN);
  EXPECT_TRUE((Ball{0, 0.5}(Pose2(1, 1, 2), Point2(1, 1), &J)).isZero(0));
  EXPECT_TRUE(J.all.isZero(0));
}

TEST(RangeBall, CostIsTheLeastSquaredDistanceToAPointOfTheBall) {  // paper C (4)
  const double distance = 2, sigma = 0.7;
  const Point2 a(0, 0), b(3, 1);
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 100000; ++i) {
    const double angle = 2e-5 * kPi * i;
    least = std::min(least, (b.value - distance * Vector<2>(std::cos(angle), std::sin(angle))).squaredNorm() / (sigma * sigma));
  }
  EXPECT_NEAR((RangeBall<Point2, Point2>{distance, sigma}(a, b)).squaredNorm(), least, 1e-6);
}

TEST(RangeBall, RefusesNumbersThatAreNone) {
  EXPECT_THROW((Ball{NAN, 1}).validate(), BadNumber);
  EXPECT_THROW((Ball{-1, 1}).validate(), BadNumber);
  EXPECT_THROW((Ball{1, 0}).validate(), BadNumber);
  EXPECT_THROW((Ball{1, INFINITY}).validate(), BadNumber);
}

TEST(RangeBall, RawIsTheWayToTheBallInMetres) {
  const RangeBall<Point2, Point2> ball{3, 0.5};
  EXPECT_TRUE(ball.raw(ball({0, 0}, {3, 4})).isApprox(Vector<2>(1.2, 1.6), 1e-15));  // 2 m along (0.6, 0.8)
}

}  // namespace
}  // namespace holdfast

namespace holdfast::testing {

template <class A, class B>
struct Sample<RangeBall<A, B>> : RandomVariables<RangeBall<A, B>> {
  static RangeBall<A, B> factor(std::mt19937_64& rng) { return {radius(rng), uniform(rng, 0.5, 2)}; }
};

}  // namespace holdfast::testing

HOLDFAST_CONFORMS(OnPairs<RangeBall>);
