#include <gtest/gtest.h>

#include <Eigen/LU>
#include <holdfast/factors/constant_turn.hpp>
#include <holdfast/factors/detail/transition.hpp>
#include <holdfast/testing.hpp>

#include "tests/conforms.hpp"

namespace holdfast {
namespace {

using Turn = ConstantTurn<Motion2>;

TEST(ConstantTurn, FollowsACircleToTheLeft) {
  // 2 m/s at π/2 rad/s: radius 4/π; a quarter of the circle in 1 s.
  const Turn quarter{1, kPi / 2, Matrix<4, 4>::Identity()};
  const double radius = 4 / kPi;
  EXPECT_LT(quarter(Motion2(0, 2, 0, 0), Motion2(radius, 0, radius, 2)).norm(), 1e-15);
}

TEST(ConstantTurn, IsConstantVelocityWithoutATurn) {
  const Turn straight{0.7, 0, Matrix<4, 4>::Identity()};
  EXPECT_TRUE(straight.transition().isApprox(transition<Motion2>(0.7), 1e-15));
  for (const double omega : {1e-300, 1e-12, 1e-8, 1e-4}) {
    const Turn turn{0.7, omega, Matrix<4, 4>::Identity()};
    EXPECT_LT((turn.transition() - straight.transition()).norm(), 2 * omega + 1e-15) << omega;
  }
}

TEST(ConstantTurn, IsThePrintedMatrix) {  // paper B (3)
  const double dt = 0.5, w = 2 * kPi / 180;
  const Matrix<4, 4> F = Turn{dt, w, Matrix<4, 4>::Identity()}.transition();
  Matrix<4, 4> printed;
  printed << 1, std::sin(w * dt) / w, 0, -(1 - std::cos(w * dt)) / w, 0, std::cos(w * dt), 0, -std::sin(w * dt), 0,
      (1 - std::cos(w * dt)) / w, 1, std::sin(w * dt) / w, 0, std::sin(w * dt), 0, std::cos(w * dt);
  EXPECT_TRUE(F.isApprox(printed, 1e-13));
}

TEST(ConstantTurn, ComposesAndKeepsTheSpeed) {
  const auto F = [](double dt) { return Turn{dt, -0.4, Matrix<4, 4>::Identity()}.transition(); };
  EXPECT_TRUE((F(1.2) * F(0.9)).isApprox(F(2.1), 1e-14));
  const Vector<4> x = F(1.2) * Vector<4>(1, 3, 2, 4);
  EXPECT_NEAR(std::hypot(x[1], x[3]), 5, 1e-14);
}

TEST(ConstantTurn, WhitensAndLinearisesExactly) {
  std::mt19937_64 rng(1);
  const Matrix<4, 4> S = testing::random_covariance<4>(rng);
  const auto turn = Turn::from_covariance(0.5, 0.3, S);
  const auto x = testing::random_variable<Motion2>(rng), y = testing::random_variable<Motion2>(rng);
  const Vector<4> error = turn.transition() * x.value - y.value;
  EXPECT_NEAR(turn(x, y).squaredNorm(), error.dot(S.inverse() * error), 1e-9 * turn(x, y).squaredNorm());
  EXPECT_LT(testing::jacobian_error(turn, x, y), 1e-10);
}

TEST(ConstantTurn, RefusesNumbersThatAreNone) {
  const Matrix<4, 4> W = Matrix<4, 4>::Identity();
  EXPECT_THROW((Turn{0, 1, W}).validate(), BadNumber);
  EXPECT_THROW((Turn{1, NAN, W}).validate(), BadNumber);
  EXPECT_THROW((Turn{1, 1, NAN * W}).validate(), BadNumber);
  EXPECT_THROW(Turn::from_covariance(1, 1, -W), BadNumber);
}

}  // namespace
}  // namespace holdfast

namespace holdfast::testing {

template <>
struct Sample<ConstantTurn<Motion2>> : RandomVariables<ConstantTurn<Motion2>> {
  static ConstantTurn<Motion2> factor(std::mt19937_64& rng) {
    const double dt = uniform(rng, 0.1, 1), omega = uniform(rng, -1, 1);
    return ConstantTurn<Motion2>::from_covariance(dt, omega, random_covariance<4>(rng));
  }
};

}  // namespace holdfast::testing

HOLDFAST_CONFORMS(ConstantTurn<Motion2>);
