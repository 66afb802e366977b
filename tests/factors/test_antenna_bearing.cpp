#include <gtest/gtest.h>

#include <holdfast/factors/antenna_bearing.hpp>
#include <holdfast/factors/von_mises_bearing.hpp>
#include <holdfast/testing.hpp>

#include "tests/conforms.hpp"

namespace holdfast {
namespace {

using Seen = AntennaBearingBody<Pose2, Point2>;

TEST(AntennaBearing, InNumbers) {
  // The antenna at (1, 2.5), looking along y; (4, 6.5) is 4 ahead and 3 to the right of it.
  EXPECT_LT((Seen{{0.8, -0.6}, 4, {0.5, 0}, {0, 0}}(Pose2(1, 2, kPi / 2), Point2(4, 6.5))).norm(), 1e-12);
  const Vector<2> r = Seen{{1, 0}, 4, {0.5, 0}, {0, 0}}(Pose2(1, 2, kPi / 2), Point2(4, 6.5));
  EXPECT_NEAR(r[0], 0.4, 1e-12);
  EXPECT_NEAR(r[1], 1.2, 1e-12);
  EXPECT_LT((AntennaBearing<Pose2, Point2>{{0.6, 0.8}, 4, {0.5, 0}, {0, 0}}(Pose2(1, 2, kPi / 2), Point2(4, 6.5))).norm(), 1e-12);
}

TEST(AntennaBearing, WithoutLeverArmsIsThatOfThePositions) {
  std::mt19937_64 rng(1);
  const Pose3 a = testing::random_variable<Pose3>(rng), b = testing::random_variable<Pose3>(rng);
  const Vector<3> u = testing::random_unit<3>(rng), none = Vector<3>::Zero();
  EXPECT_LT((AntennaBearingBody<Pose3, Pose3>{u, 9, none, none}(a, b) - VonMisesBearingBody<Pose3, Pose3>{u, 9}(a, b)).norm(), 1e-14);
  EXPECT_LT((AntennaBearing<Pose3, Pose3>{u, 9, none, none}(a, b) - VonMisesBearing<Pose3, Pose3>{u, 9}(a, b)).norm(), 1e-14);
}

TEST(AntennaBearing, InTheBodyIsTheSameInEveryFrame) {
  std::mt19937_64 rng(3);
  const Pose3 T = testing::random_variable<Pose3>(rng), a = testing::random_variable<Pose3>(rng), b = testing::random_variable<Pose3>(rng);
  const AntennaBearingBody<Pose3, Pose3> seen{testing::random_unit<3>(rng), 9, {0.3, 0.1, 0}, {0, 0.2, 0}};
  EXPECT_LT((seen(a, b) - seen(T * a, T * b)).norm(), 1e-10);
}

TEST(AntennaBearing, SaysNothingWhereTheAntennasCoincide) {
  Jacobians<Seen> J;
  J.all.setConstant(NAN);
  EXPECT_TRUE((Seen{{1, 0}, 4, {1, 0}, {0, 0}}(Pose2(0, 0, 0), Point2(1, 0), &J)).isZero(0));
  EXPECT_TRUE(J.all.isZero(0));
}

TEST(AntennaBearing, RefusesNumbersThatAreNone) {
  EXPECT_THROW((Seen{{1, 1}, 4, {0, 0}, {0, 0}}).validate(), BadNumber);
  EXPECT_THROW((Seen{{1, 0}, 0, {0, 0}, {0, 0}}).validate(), BadNumber);
  EXPECT_THROW((Seen{{1, 0}, 1, {0, 0}, {0.1, 0}}).validate(), BadNumber);
  EXPECT_NO_THROW((Seen{{1, 0}, 1, {0.3, 0}, {0, 0}}).validate());
}

}  // namespace
}  // namespace holdfast

namespace holdfast::testing {

template <class F, class A, class B>
F between_antennas(std::mt19937_64& rng) {
  F seen{};
  seen.direction = random_unit<space_dim<A>>(rng);
  seen.kappa = uniform(rng, 1, 100);
  seen.lever_a.setZero();
  seen.lever_b.setZero();
  if constexpr (is_pose<A>) seen.lever_a = random_vector<space_dim<A>>(rng, 0.3);
  if constexpr (is_pose<B>) seen.lever_b = random_vector<space_dim<A>>(rng, 0.3);
  return seen;
}
template <class A, class B>
struct Sample<AntennaBearing<A, B>> : RandomVariables<AntennaBearing<A, B>> {
  static AntennaBearing<A, B> factor(std::mt19937_64& rng) { return between_antennas<AntennaBearing<A, B>, A, B>(rng); }
};
template <class P, class B>
struct Sample<AntennaBearingBody<P, B>> : RandomVariables<AntennaBearingBody<P, B>> {
  static AntennaBearingBody<P, B> factor(std::mt19937_64& rng) { return between_antennas<AntennaBearingBody<P, B>, P, B>(rng); }
};

}  // namespace holdfast::testing

HOLDFAST_CONFORMS(AntennaBearing<Pose2, Point2>, AntennaBearing<Pose3, Pose3>, AntennaBearingBody<Pose2, Point2>,
                  AntennaBearingBody<Pose3, Pose3>);
