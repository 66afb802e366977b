#include <gtest/gtest.h>

#include <holdfast/factors/antenna_range_with_lever.hpp>
#include <holdfast/testing.hpp>

#include "tests/conforms.hpp"

namespace holdfast {
namespace {

using Seen = AntennaRangeWithLever<Pose2, Point2>;

TEST(AntennaRangeWithLever, InNumbers) {
  // A robot at (1, 2) looking along y, its antenna 0.5 m ahead: at (1, 2.5), 5 m from (4, 6.5).
  EXPECT_NEAR((Seen{5.05, 0.1}(Pose2(1, 2, kPi / 2), Point2(4, 6.5), Point2(0.5, 0), Scalar(0.15)))[0], 1, 1e-12);
}

TEST(AntennaRangeWithLever, HasNoSlopeWhereTheAntennaIsAtTheAnchor) {
  Jacobians<Seen> J;
  J.all.setConstant(NAN);
  EXPECT_DOUBLE_EQ((Seen{5, 0.5}(Pose2(0, 0, 0), Point2(1, 0), Point2(1, 0), Scalar(0), &J))[0], -10);
  EXPECT_TRUE(J.all.leftCols(7).isZero(0));
  EXPECT_DOUBLE_EQ(J.all(0, 7), 2);
}

TEST(AntennaRangeWithLever, RefusesNumbersThatAreNone) {
  EXPECT_THROW((Seen{-1, 1}).validate(), BadNumber);
  EXPECT_THROW((Seen{1, NAN}).validate(), BadNumber);
}

}  // namespace
}  // namespace holdfast

HOLDFAST_CONFORMS(AntennaRangeWithLever<Pose2, Point2>, AntennaRangeWithLever<Pose3, Point3>);
