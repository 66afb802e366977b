#include <gtest/gtest.h>

#include <Eigen/LU>
#include <holdfast/factors/constant_turn.hpp>
#include <holdfast/factors/coordinated_turn.hpp>
#include <holdfast/factors/white_acceleration.hpp>
#include <holdfast/testing.hpp>

#include "tests/conforms.hpp"

namespace holdfast {
namespace {

const CoordinatedTurn kTurn{0.5, 0.3, 0.02};

TEST(CoordinatedTurn, IsZeroOnACircle) {
  // 2 m/s at π/2 rad/s: radius 4/π; a quarter of the circle in 1 s.
  const double radius = 4 / kPi;
  EXPECT_LT((CoordinatedTurn{1, 1, 1})(Turning2(0, 2, 0, 0, kPi / 2), Turning2(radius, 0, radius, 2, kPi / 2)).norm(), 1e-14);
}

TEST(CoordinatedTurn, IsConstantTurnWhereTheRateIsKnown) {
  std::mt19937_64 rng(1);
  const auto x = testing::random_variable<Motion2>(rng);
  for (const double omega : {-0.8, -1e-9, 0.0, 1e-6, 3e-4, 2.0}) {
    const Vector<4> turned = ConstantTurn<Motion2>{0.5, omega, Matrix<4, 4>::Identity()}.transition() * x.value;
    EXPECT_LT((kTurn.predicted(Turning2(x, omega)).mean.head<4>() - turned).norm(), 1e-12 * turned.norm()) << omega;
  }
}

TEST(CoordinatedTurn, WhitensByItsCovariance) {
  std::mt19937_64 rng(2);
  const auto x = testing::random_variable<Turning2>(rng), y = testing::random_variable<Turning2>(rng);
  const Vector<5> r = kTurn(x, y), error = kTurn.predicted(x).mean - y.value;
  EXPECT_NEAR(r.squaredNorm(), error.dot(kTurn.covariance().inverse() * error), 1e-9 * r.squaredNorm());
  const auto straight = WhiteAcceleration<Motion2>::continuous(kTurn.dt, kTurn.q).sqrt_information;
  EXPECT_LT((kTurn.covariance().topLeftCorner<4, 4>() * straight * straight - Matrix<4, 4>::Identity()).norm(), 1e-9);
}

TEST(CoordinatedTurn, JacobiansAtAnyRate) {
  std::mt19937_64 rng(3);
  const auto x = testing::random_variable<Motion2>(rng), y = testing::random_variable<Motion2>(rng);
  for (const double omega : {0.0, 1e-8, 1e-4, -3e-4, 0.02, -0.7, 3.0})
    EXPECT_LT(testing::jacobian_error(kTurn, Turning2(x, omega), Turning2(y, 0.1)), 1e-6) << omega;
}

TEST(CoordinatedTurn, RefusesNumbersThatAreNone) {
  EXPECT_THROW((CoordinatedTurn{0, 1, 1}).validate(), BadNumber);
  EXPECT_THROW((CoordinatedTurn{1, -1, 1}).validate(), BadNumber);
  EXPECT_THROW((CoordinatedTurn{1, 1, NAN}).validate(), BadNumber);
}

}  // namespace
}  // namespace holdfast

HOLDFAST_CONFORMS(CoordinatedTurn);
