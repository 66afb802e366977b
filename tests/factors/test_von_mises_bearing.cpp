#include <gtest/gtest.h>

#include <holdfast/factors/von_mises_bearing.hpp>
#include <holdfast/graph/variables.hpp>
#include <holdfast/testing.hpp>

#include "tests/conforms.hpp"

namespace holdfast {
namespace {

using testing::jacobian_error;
using testing::random_unit;
using testing::random_variable;

TEST(VonMisesBearing, HalfSquareIsTheVonMisesFisherLikelihood) {  // paper C (3): −κ uᵀe, up to the constant κ
  std::mt19937_64 rng(1);
  for (int i = 0; i < 20; ++i) {
    const auto a = random_variable<Point3>(rng), b = random_variable<Point3>(rng);
    const VonMisesBearing<Point3, Point3> factor{random_unit<3>(rng), 40};
    const double cosine = factor.direction.dot((b.value - a.value).normalized());
    EXPECT_NEAR(0.5 * factor(a, b).squaredNorm(), 40 - 40 * cosine, 1e-12);
  }
}

TEST(VonMisesBearing, PointsFromTheFirstToTheSecond) {
  const VonMisesBearing<Point2, Motion2> east{{1, 0}, 9};
  EXPECT_LT(east(Point2(1, 1), Motion2(5, 0, 1, 0)).norm(), 1e-15);
  EXPECT_TRUE(east(Point2(1, 1), Motion2(1, 0, 3, 0)).isApprox(Vector<2>(3, -3)));
}

TEST(VonMisesBearingBody, IsMeasuredFromTheBody) {
  const VonMisesBearingBody<Pose2, Point2> left{{0, 1}, 4};
  EXPECT_LT(left(Pose2(0, 0, kPi / 2), Point2(-7, 0)).norm(), 1e-15);  // looking north, west is left
  EXPECT_TRUE(left(Pose2(0, 0, kPi / 2), Point2(0, 3)).isApprox(Vector<2>(-2, 2), 1e-15));
}

TEST(VonMisesBearing, JacobiansAreExact) {
  std::mt19937_64 rng(2);
  for (int i = 0; i < 10; ++i) {
    const VonMisesBearing<Pose2, Point2> world2{random_unit<2>(rng), 30};
    EXPECT_LT(jacobian_error(world2, random_variable<Pose2>(rng), random_variable<Point2>(rng)), 1e-8);
    const VonMisesBearingBody<Pose2, Point2> body2{random_unit<2>(rng), 30};
    EXPECT_LT(jacobian_error(body2, random_variable<Pose2>(rng), random_variable<Point2>(rng)), 1e-8);
    const VonMisesBearingBody<Pose3, Pose3> body3{random_unit<3>(rng), 30};
    EXPECT_LT(jacobian_error(body3, random_variable<Pose3>(rng), random_variable<Pose3>(rng)), 1e-8);
    EXPECT_LT(jacobian_error(body3, testing::near_identity<Pose3>(rng), random_variable<Pose3>(rng)), 1e-8);
  }
}

template <class F, class A, class B>
void expect_nothing_at_zero_distance(const F& factor, const A& a, const B& b) {
  Jacobians<F> J;
  J.all.setConstant(NAN);
  EXPECT_TRUE(factor(a, b, &J).isZero(0));
  EXPECT_TRUE(J.all.isZero(0));
}

TEST(VonMisesBearing, SaysNothingWhereBothPositionsCoincide) {
  expect_nothing_at_zero_distance(VonMisesBearing<Point2, Point2>{{1, 0}, 9}, Point2(1, 2), Point2(1, 2 + 5e-10));
  expect_nothing_at_zero_distance(VonMisesBearingBody<Pose2, Point2>{{1, 0}, 9}, Pose2(1, 2, 1), Point2(1, 2));
}

TEST(VonMisesBearing, RefusesNumbersThatAreNone) {
  using F = VonMisesBearing<Point2, Point2>;
  using Body = VonMisesBearingBody<Pose2, Point2>;
  EXPECT_THROW((F{{1, 0.01}, 1}).validate(), BadNumber);
  EXPECT_THROW((F{{NAN, 0}, 1}).validate(), BadNumber);
  EXPECT_THROW((F{{1, 0}, 0}).validate(), BadNumber);
  EXPECT_THROW((Body{{0, 0}, 1}).validate(), BadNumber);
  EXPECT_THROW((Body{{1, 0}, INFINITY}).validate(), BadNumber);
  EXPECT_NO_THROW((F{{0.6, 0.8}, 1}).validate());
}

}  // namespace
}  // namespace holdfast

namespace holdfast::testing {

template <class A, class B>
struct Sample<VonMisesBearing<A, B>> : RandomVariables<VonMisesBearing<A, B>> {
  static VonMisesBearing<A, B> factor(std::mt19937_64& rng) { return {random_unit<space_dim<A>>(rng), uniform(rng, 1, 100)}; }
};

template <class P, class B>
struct Sample<VonMisesBearingBody<P, B>> : RandomVariables<VonMisesBearingBody<P, B>> {
  static VonMisesBearingBody<P, B> factor(std::mt19937_64& rng) { return {random_unit<space_dim<P>>(rng), uniform(rng, 1, 100)}; }
};

}  // namespace holdfast::testing

HOLDFAST_CONFORMS(OnSomePairs<VonMisesBearing>, OnPoses<VonMisesBearingBody>);
