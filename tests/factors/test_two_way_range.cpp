#include <gtest/gtest.h>

#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/two_way_range.hpp>
#include <holdfast/graph/graph.hpp>
#include <holdfast/solvers/irls/irls.hpp>
#include <holdfast/testing.hpp>

#include "tests/conforms.hpp"

namespace holdfast {
namespace {

using Uwb = TwoWayRange<Pose2, Point2>;

/// What two radios at this distance measure, the clock of a faster by so many ppm.
struct Exchange {
  double round_a, reply_b, round_b, reply_a;
  Exchange(double distance, double reply_b_true, double reply_a_true, double ppm_a, double ppm_b) {
    const double flight = distance / kSpeedOfLight, a = 1 + 1e-6 * ppm_a, b = 1 + 1e-6 * ppm_b;
    round_a = a * (2 * flight + reply_b_true);
    reply_b = b * reply_b_true;
    round_b = b * (2 * flight + reply_a_true);
    reply_a = a * reply_a_true;
  }
};

TEST(TwoWayRange, InNumbers) {
  EXPECT_NEAR(single_sided_range(3e-6, 1e-6), kSpeedOfLight * 1e-6, 1e-9);
  // Sound in water: 40 ms for both ways and no reply is 30 m; the antenna at (1, 2.5) is 5 m from the anchor.
  const Uwb acoustic{0.04, 0.0, 0.5, 1500, {0.5, 0}, {0, 0}};
  EXPECT_NEAR(acoustic(Pose2(1, 2, kPi / 2), Point2(4, 6.5), Scalar(0), Scalar(0))[0], -50, 1e-9);
  EXPECT_NEAR(acoustic(Pose2(1, 2, kPi / 2), Point2(4, 6.5), Scalar(25), Scalar(0))[0], 0, 1e-9);
}

TEST(TwoWayRange, DriftSpoilsSingleSidedAndNotDoubleSided) {
  const Exchange one(50, 1e-3, 3e-4, 12, -8);  // 20 ppm apart, replies of unlike lengths
  EXPECT_NEAR(single_sided_range(one.round_a, one.reply_b), 50 + 0.5 * kSpeedOfLight * 20e-6 * 1e-3, 0.01);  // 3 m too long
  EXPECT_NEAR(double_sided_range(one.round_a, one.reply_b, one.round_b, one.reply_a), 50, 0.001);
  EXPECT_NEAR(Uwb({one.round_a, one.reply_b, 1, kSpeedOfLight, {0, 0}, {0, 0}})(Pose2(0, 0, 0), Point2(50, 0), Scalar(0), Scalar(20))[0], 0,
              0.001);
}

TEST(TwoWayRange, DriftIsFoundFromRepliesOfUnlikeLengths) {
  const Agent A('A');
  const Key anchor('L', 0), bias('B', 0), drift('D', 0);
  std::mt19937_64 rng(2);
  std::normal_distribution<double> normal;
  Graph graph;
  Values values;
  values.insert(anchor, Point2(0, 0));
  values.insert(bias, Scalar(0));
  values.insert(drift, Scalar(0));
  graph.fix(anchor);
  graph.add(Prior<Scalar>::from_sigmas(0, Vector<1>(1)), {bias});
  graph.add(Prior<Scalar>::from_sigmas(0, Vector<1>(20)), {drift});
  for (int k = 0; k < 40; ++k) {
    const double distance = 5 + 0.5 * k;
    const Exchange one(distance + 0.15, k % 2 == 0 ? 3e-4 : 2e-3, 3e-4, 9, 2);
    values.insert(A(k), Pose2(distance, 0, 0));
    graph.fix(A(k));
    const double noise = 2 * 0.03 * normal(rng) / kSpeedOfLight;
    graph.add(Uwb{one.round_a + noise, one.reply_b, 0.03, kSpeedOfLight, {0, 0}, {0, 0}}, {A(k), anchor, bias, drift});
  }
  ASSERT_TRUE(Irls().solve(graph, values).usable());
  EXPECT_NEAR(values.at<Scalar>(bias).value, 0.15, 0.03);
  EXPECT_NEAR(values.at<Scalar>(drift).value, 7, 0.15);
}

TEST(TwoWayRange, RefusesTimesThatAreNone) {
  EXPECT_THROW(double_sided_range(0, 0, 0, 0), BadNumber);
  EXPECT_THROW(double_sided_range(NAN, 1, 1, 1), BadNumber);
  EXPECT_THROW((Uwb{-1, 0, 1, 1, {0, 0}, {0, 0}}).validate(), BadNumber);
  EXPECT_THROW((Uwb{1, 0, 1, 0, {0, 0}, {0, 0}}).validate(), BadNumber);
  EXPECT_NO_THROW((Uwb{1e-3, 1e-3, 0.1, kSpeedOfLight, {0.3, 0}, {0, 0}}).validate());
}

}  // namespace
}  // namespace holdfast

namespace holdfast::testing {

// An acoustic modem that answers after 10 to 20 s: 7.5 to 15 mm for each ppm.
template <class A, class B>
struct Sample<TwoWayRange<A, B>> : RandomVariables<TwoWayRange<A, B>> {
  static TwoWayRange<A, B> factor(std::mt19937_64& rng) {
    TwoWayRange<A, B> range{};
    range.reply = uniform(rng, 10, 20);
    range.round = range.reply + uniform(rng, 0.002, 0.03);
    range.sigma = uniform(rng, 0.5, 2);
    range.speed = 1500;
    range.lever_a.setZero();
    range.lever_b.setZero();
    if constexpr (is_pose<A>) range.lever_a = random_vector<space_dim<A>>(rng, 0.3);
    return range;
  }
};

}  // namespace holdfast::testing

HOLDFAST_CONFORMS(TwoWayRange<Pose2, Point2>, TwoWayRange<Point3, Point3>);
