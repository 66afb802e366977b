// hessian() of factors by hand. That it is the second derivative of ½‖r‖²: tests/factors/test_every_factor.cpp.
#include <gtest/gtest.h>

#include <holdfast/factors/missing_distance.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/factors/range_ball.hpp>
#include <holdfast/factors/range_bearing_ball.hpp>
#include <holdfast/graph/variables.hpp>

namespace holdfast {
namespace {

// σ = 0.5, 3 m measured, the points 4 m apart along x: (1 − 3/4)/σ² = 1 across, 1/σ² = 4 along. JᵀJ has (1 − 3/4)²/σ² = 1/4 across.
TEST(Hessian, OfABallByHand) {
  const RangeBall<Point2, Point2> ball{3, 0.5};
  const Matrix<4, 4> outside = ball.hessian({0, 0}, {4, 0});
  EXPECT_TRUE((outside.bottomRightCorner<2, 2>().isApprox(Matrix<2, 2>(Vector<2>(4, 1).asDiagonal()), 1e-15))) << outside;
  EXPECT_TRUE((outside.topRightCorner<2, 2>().isApprox(-Matrix<2, 2>(Vector<2>(4, 1).asDiagonal()), 1e-15))) << outside;
  EXPECT_TRUE(ball.hessian({0, 0}, {2, 0}).isZero(0));
  EXPECT_TRUE(ball.hessian({1, 1}, {1, 1}).isZero(0));
}

// Nearer than measured, the cost of a range falls to both sides.
TEST(Hessian, OfARangeIsIndefiniteWhereThePositionsAreTooNear) {
  const Range<Point2, Point2> range{3, 0.5};
  const Matrix<4, 4> H = range.hessian({0, 0}, {2, 0});
  EXPECT_NEAR(H(2, 2), 4, 1e-14);
  EXPECT_NEAR(H(3, 3), -2, 1e-14);  // (1 − 3/2)/σ²
  EXPECT_TRUE(range.hessian({1, 1}, {1, 1}).isZero(0));
}

// c is linear inside: the distance is measured as 3 m along x, the points are 1 m apart, v = x + σ²κ/d u = (2, 0).
TEST(Hessian, OfARangeAndABearingByHand) {
  const RangeBearingBall<Point2, Point2> ball{3, 1, {1, 0}, 3};
  EXPECT_TRUE(ball.hessian({0, 0}, {1, 0}).isZero(0));
  const Matrix<4, 4> outside = ball.hessian({0, 0}, {5, 0});  // v = (6, 0)
  EXPECT_TRUE((outside.bottomRightCorner<2, 2>().isApprox(Matrix<2, 2>(Vector<2>(1, 0.5).asDiagonal()), 1e-15))) << outside;
}

TEST(Hessian, OfAMissingDistanceAtItsSingularPointIsThatOfOmega) {
  const Matrix<5, 5> H = MissingDistanceBall<Point2, Point2>{0.5}.hessian({1, 1}, {1, 1}, Scalar(-1));
  EXPECT_EQ(H(4, 4), 4);
  EXPECT_TRUE((H.topRows<4>().isZero(0)));
}

}  // namespace
}  // namespace holdfast
