#include <gtest/gtest.h>

#include <holdfast/factors/range.hpp>
#include <holdfast/graph/variables.hpp>
#include <holdfast/testing.hpp>

#include "tests/conforms.hpp"

namespace holdfast {
namespace {

using testing::jacobian_error;
using testing::random_variable;

TEST(Range, IsTheDistanceErrorInSigmas) {
  EXPECT_DOUBLE_EQ((Range<Point2, Point2>{4, 0.5}(Point2(1, 1), Point2(4, 5)))[0], 2);
  EXPECT_DOUBLE_EQ((Range<Motion2, Pose2>{6, 0.5}(Motion2(1, 9, 1, 9), Pose2(4, 5, 1)))[0], -2);
  EXPECT_DOUBLE_EQ((Range<Point3, Point3>{0, 1}(Point3(0, 0, 0), Point3(2, 3, 6)))[0], 7);
}

TEST(Range, GrowsAlongTheLineOfSight) {
  Jacobians<Range<Point2, Pose2>> J;
  Range<Point2, Pose2>{1, 0.5}(Point2(0, 0), Pose2(3, 4, 0.3), &J);
  EXPECT_TRUE(J.wrt<0>().isApprox(Matrix<1, 2>(-1.2, -1.6), 1e-15));
  EXPECT_TRUE(J.wrt<1>().isApprox(Matrix<1, 3>(1.2, 1.6, 0), 1e-15));
}

TEST(Range, JacobianIsExact) {
  std::mt19937_64 rng(1);
  for (int i = 0; i < 10; ++i) {
    EXPECT_LT(jacobian_error(Range<Pose2, Point2>{3, 0.5}, random_variable<Pose2>(rng), random_variable<Point2>(rng)), 1e-9);
    EXPECT_LT(jacobian_error(Range<Accel3, Pose3>{3, 0.5}, random_variable<Accel3>(rng), random_variable<Pose3>(rng)), 1e-9);
  }
}

TEST(Range, HasNoSlopeWhereBothPositionsCoincide) {
  const Range<Point2, Point2> range{3, 0.5};
  for (const double gap : {0.0, 1e-12, 0.9e-9}) {
    Jacobians<Range<Point2, Point2>> J;
    J.all.setConstant(NAN);
    EXPECT_EQ(range(Point2(1, 2), Point2(1 + gap, 2), &J)[0], -6);
    EXPECT_TRUE(J.all.isZero(0)) << gap;
  }
  Jacobians<Range<Point2, Point2>> J;
  range(Point2(0, 0), Point2(2e-9, 0), &J);
  EXPECT_DOUBLE_EQ(J.all(0, 2), 2);
}

TEST(Range, IsRelaxedToItsBall) {
  const Range<Point2, Point2> range{3, 0.5};
  for (const double x : {0.5, 3.0, 8.0}) {
    const double exact = range(Point2(0, 0), Point2(x, 0))[0], relaxed = range.relaxed()(Point2(0, 0), Point2(x, 0)).norm();
    EXPECT_EQ(relaxed, std::max(0.0, exact));  // never dearer, and the same outside
  }
}

TEST(Range, RefusesNumbersThatAreNone) {
  using F = Range<Point2, Point2>;
  EXPECT_THROW((F{NAN, 1}).validate(), BadNumber);
  EXPECT_THROW((F{INFINITY, 1}).validate(), BadNumber);
  EXPECT_THROW((F{-1, 1}).validate(), BadNumber);
  EXPECT_THROW((F{1, 0}).validate(), BadNumber);
  EXPECT_THROW((F{1, -1}).validate(), BadNumber);
  EXPECT_NO_THROW((F{0, 1}).validate());
}

TEST(Range, RawIsTheErrorInMetres) {
  const Range<Point2, Point2> range{3, 0.5};
  EXPECT_DOUBLE_EQ(range.raw(range({0, 0}, {3, 4}))[0], 2);
}

}  // namespace
}  // namespace holdfast

namespace holdfast::testing {

template <class A, class B>
struct Sample<Range<A, B>> : RandomVariables<Range<A, B>> {
  static Range<A, B> factor(std::mt19937_64& rng) { return {uniform(rng, 0, 30), uniform(rng, 0.5, 2)}; }
};

}  // namespace holdfast::testing

HOLDFAST_CONFORMS(OnPairs<Range>);
