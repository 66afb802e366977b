#include <gtest/gtest.h>

#include <holdfast/factors/position_step.hpp>
#include <holdfast/graph/variables.hpp>
#include <holdfast/testing.hpp>

#include "tests/conforms.hpp"

namespace holdfast {
namespace {

TEST(PositionStep, IsTheStepInSigmas) {
  EXPECT_TRUE((PositionStep<Point2, Point2>{0.5}(Point2(1, 1), Point2(2, 4))).isApprox(Vector<2>(2, 6)));
  EXPECT_TRUE((PositionStep<Pose2, Motion2>{2}(Pose2(1, 1, 3), Motion2(2, 9, 4, 9))).isApprox(Vector<2>(0.5, 1.5)));
}

TEST(PositionStep, DoesNotCareForRotations) {
  Jacobians<PositionStep<Pose3, Pose3>> J;
  J.all.setConstant(NAN);
  PositionStep<Pose3, Pose3>{0.5}(Pose3(), Pose3(), &J);
  EXPECT_TRUE((J.wrt<0>().rightCols<3>().isZero(0)));
  EXPECT_TRUE((J.wrt<1>().leftCols<3>().isApprox(2 * Matrix<3, 3>::Identity())));
  EXPECT_LT(testing::jacobian_error(PositionStep<Pose3, Pose3>{0.5}, Pose3(), Pose3()), 1e-10);
}

TEST(PositionStep, RefusesNumbersThatAreNone) {
  using F = PositionStep<Point2, Point2>;
  EXPECT_THROW((F{0}).validate(), BadNumber);
  EXPECT_THROW((F{NAN}).validate(), BadNumber);
}

TEST(PositionStep, RawIsTheStepInMetres) {
  const PositionStep<Point2, Point2> step{0.5};
  EXPECT_TRUE(step.raw(step({1, 2}, {4, 6})).isApprox(Vector<2>(3, 4)));
}

}  // namespace
}  // namespace holdfast

HOLDFAST_CONFORMS(OnSomePairs<PositionStep>);
