#include <gtest/gtest.h>

#include <holdfast/factors/time_difference.hpp>
#include <holdfast/testing.hpp>

#include "tests/conforms.hpp"

namespace holdfast {
namespace {

using Heard = TimeDifference<Pose2, Point2, Point2>;

TEST(TimeDifference, InNumbers) {
  // The antenna at (1, 2.5): 5 m from c = (4, 6.5), 2.5 m from b = (1, 0).
  EXPECT_NEAR((Heard{2, 0.1, {0.5, 0}}(Pose2(1, 2, kPi / 2), Point2(1, 0), Point2(4, 6.5)))[0], 5, 1e-12);
  const TimeDifferenceWithOffset<Pose2, Point2, Point2> late{2, 0.1, {0.5, 0}};
  EXPECT_NEAR(late(Pose2(1, 2, kPi / 2), Point2(1, 0), Point2(4, 6.5), Scalar(-0.3))[0], 2, 1e-12);
}

TEST(TimeDifference, TurnsItsSignWithTheAnchorsAndIsTheSameInEveryFrame) {
  std::mt19937_64 rng(3);
  const Pose3 T = testing::random_variable<Pose3>(rng), a = testing::random_variable<Pose3>(rng);
  const Point3 b(5, 1, -2), c(-3, 4, 6), Tb((T * b.value).eval()), Tc((T * c.value).eval());
  const TimeDifference<Pose3, Point3, Point3> one{0.7, 0.2, {0.3, 0.1, 0}}, other{-0.7, 0.2, {0.3, 0.1, 0}};
  EXPECT_NEAR(one(a, b, c)[0], -other(a, c, b)[0], 1e-12);
  EXPECT_NEAR(one(a, b, c)[0], one(T * a, Tb, Tc)[0], 1e-10);
}

TEST(TimeDifference, HasNoSlopeTowardsAnAnchorThatItIsAt) {
  Jacobians<Heard> J;
  J.all.setConstant(NAN);
  EXPECT_DOUBLE_EQ((Heard{0, 0.5, {1, 0}}(Pose2(0, 0, 0), Point2(1, 0), Point2(3, 0), &J))[0], 4);
  EXPECT_TRUE(J.all.allFinite());
  EXPECT_TRUE(J.wrt<1>().isZero(0));
  EXPECT_NEAR(J.wrt<2>()(0, 0), 2, 1e-12);
}

TEST(TimeDifference, RefusesNumbersThatAreNone) {
  EXPECT_THROW((Heard{NAN, 1, {0, 0}}).validate(), BadNumber);
  EXPECT_THROW((Heard{1, 0, {0, 0}}).validate(), BadNumber);
  EXPECT_THROW((TimeDifference<Point2, Point2, Point2>{1, 1, {0.1, 0}}).validate(), BadNumber);
  EXPECT_NO_THROW((Heard{-3, 1, {0.3, 0}}).validate());
}

}  // namespace
}  // namespace holdfast

namespace holdfast::testing {

/// The second anchor 6 to 20 m from a, too.
template <class F>
typename F::Variables::Tuple with_two_anchors(std::mt19937_64& rng) {
  auto x = RandomVariables<F>::variables(rng);
  auto& c = std::get<2>(x);
  constexpr int N = std::decay_t<decltype(c)>::space_dim;
  c = moved_to(c, (std::get<0>(x).position() + uniform(rng, 6, 20) * random_unit<N>(rng)).eval());
  return x;
}
template <class A>
Vector<space_dim<A>> lever_of(std::mt19937_64& rng) {
  if constexpr (is_pose<A>) return random_vector<space_dim<A>>(rng, 0.3);
  return Vector<space_dim<A>>::Zero();
}
template <class A, class B, class C>
struct Sample<TimeDifference<A, B, C>> {
  static TimeDifference<A, B, C> factor(std::mt19937_64& rng) { return {uniform(rng, -5, 5), uniform(rng, 0.5, 2), lever_of<A>(rng)}; }
  static std::tuple<A, B, C> variables(std::mt19937_64& rng) { return with_two_anchors<TimeDifference<A, B, C>>(rng); }
};
template <class A, class B, class C>
struct Sample<TimeDifferenceWithOffset<A, B, C>> {
  static TimeDifferenceWithOffset<A, B, C> factor(std::mt19937_64& rng) {
    return {uniform(rng, -5, 5), uniform(rng, 0.5, 2), lever_of<A>(rng)};
  }
  static std::tuple<A, B, C, Scalar> variables(std::mt19937_64& rng) { return with_two_anchors<TimeDifferenceWithOffset<A, B, C>>(rng); }
};

}  // namespace holdfast::testing

HOLDFAST_CONFORMS(TimeDifference<Pose2, Point2, Point2>, TimeDifference<Point3, Point3, Point3>,
                  TimeDifferenceWithOffset<Pose3, Point3, Point3>);
