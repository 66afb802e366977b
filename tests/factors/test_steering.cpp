// Motion whose noise depends on the speed, along the way and across it.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <holdfast/factors/white_acceleration.hpp>
#include <holdfast/testing.hpp>

namespace holdfast::testing {
namespace {

using Motion = WhiteAcceleration<Motion2>;

Matrix<4, 4> covariance(const Motion& motion) { return (motion.sqrt_information.transpose() * motion.sqrt_information).inverse(); }

/// density ⊗ [T³/3 T²/2; T²/2 T], axis by axis.
Matrix<4, 4> expected(const Matrix<2, 2>& density, double T) {
  Matrix<2, 2> axis;
  axis << T * T * T / 3, T * T / 2, T * T / 2, T;
  Matrix<4, 4> all;
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) all.block<2, 2>(2 * i, 2 * j) = density(i, j) * axis;
  return all;
}

TEST(Steering, IsSmallAlongTheWayAndLargeAcrossIt) {
  // At 10 m/s along [0.6 0.8]: density 0.3 along, 10 across.
  const Motion2 from(0, 6, 0, 8);
  const Motion motion = Steering<Motion2>{}(0.2, &from);
  Matrix<2, 2> density;
  density << 0.3 * 0.36 + 10 * 0.64, (0.3 - 10) * 0.48, (0.3 - 10) * 0.48, 0.3 * 0.64 + 10 * 0.36;
  EXPECT_LT((covariance(motion) - expected(density, 0.2)).norm(), 1e-9);
}

TEST(Steering, HasNoOpinionWhereNothingIsKnown) {
  const Motion motion = Steering<Motion2>{}(0.2, nullptr);
  EXPECT_LT((covariance(motion) - expected(40 * Matrix<2, 2>::Identity(), 0.2)).norm(), 1e-9);  // 0.1 · 20²
}

TEST(Steering, KnowsNoSpeedBelowTheLeastOrBeyondTwiceItsOwn) {
  const Motion2 at_rest, slow(0, 0.1, 0, 0), fast(0, 1000, 0, 0);
  const Steering<Motion2> steering;
  const Matrix<2, 2> least = Vector<2>(0.003, 0.1).asDiagonal(), most = Vector<2>(0.003 * 1600, 160).asDiagonal();
  EXPECT_LT((covariance(steering(1, &at_rest)) - expected(least, 1)).norm(), 1e-9);
  EXPECT_LT((covariance(steering(1, &slow)) - expected(least, 1)).norm(), 1e-9);
  EXPECT_LT((covariance(steering(1, &fast)) - expected(most, 1)).norm(), 1e-6);
}

TEST(Steering, OfTwoStepsIsOneOfBoth) {
  const Motion one = Motion::steered(0.3, Vector<2>(1, 2), 0.5, 4), two = one.merged(2);
  const Matrix<4, 4> F = transition<Motion2>(0.3);
  EXPECT_LT((covariance(two) - (F * covariance(one) * F.transpose() + covariance(one))).norm(), 1e-9);
  EXPECT_LT((covariance(two) - covariance(Motion::steered(0.6, Vector<2>(1, 2), 0.5, 4))).norm(), 1e-9);
}

TEST(Steering, InSpaceGoesEveryWayAcross) {
  const auto motion = WhiteAcceleration<Motion3>::steered(1, Vector<3>(0, 0, 5), 0.5, 4);
  const Matrix<6, 6> P = (motion.sqrt_information.transpose() * motion.sqrt_information).inverse();
  EXPECT_NEAR(P(1, 1), 4, 1e-9);
  EXPECT_NEAR(P(3, 3), 4, 1e-9);
  EXPECT_NEAR(P(5, 5), 0.5, 1e-9);
}

TEST(Steering, RefusesNumbersThatAreNone) {
  EXPECT_THROW(Motion::steered(0, Vector<2>(1, 0), 1, 1), BadNumber);
  EXPECT_THROW(Motion::steered(1, Vector<2>(0, 0), 1, 1), BadNumber);
  EXPECT_THROW(Motion::steered(1, Vector<2>(1, 0), 0, 1), BadNumber);
  EXPECT_THROW(Motion::steered(1, Vector<2>(1, 0), 1, NAN), BadNumber);
}

}  // namespace
}  // namespace holdfast::testing
