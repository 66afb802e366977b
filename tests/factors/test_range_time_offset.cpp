#include <gtest/gtest.h>

#include <holdfast/factors/between.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/range_time_offset.hpp>
#include <holdfast/graph/graph.hpp>
#include <holdfast/solvers/irls/irls.hpp>
#include <holdfast/testing.hpp>

#include "tests/conforms.hpp"

namespace holdfast {
namespace {

TEST(RangeTimeOffset, InNumbers) {
  // At (0, 0) with 3 m/s along x, 0.5 s later at (1.5, 0): 2.5 m from (1.5, 2.5).
  EXPECT_NEAR((RangeWithTimeOffset<Motion2, Point2>{2, 0.1}(Motion2(0, 3, 0, 0), Point2(1.5, 2.5), Scalar(0.5)))[0], 5, 1e-12);
  // And braked with 2 m/s²: 1.5 − 0.25 m.
  EXPECT_NEAR((RangeWithTimeOffset<Accel2, Point2>{2, 0.1}(Accel2(0, 3, -2, 0, 0, 0), Point2(1.25, 2.5), Scalar(0.5)))[0], 5, 1e-12);
  // A robot at (1, 2) that looks along y with 4 m/s ahead, its antenna 0.5 m ahead: after 0.25 s the antenna is at (1, 3.5).
  const AntennaRangeWithTimeOffset<Pose2, Point2> moving{4, 0.5, {0.5, 0}, {0, 0}, {4, 0}};
  EXPECT_NEAR(moving(Pose2(1, 2, kPi / 2), Point2(4, 7.5), Scalar(0.25))[0], 2, 1e-12);
}

TEST(RangeTimeOffset, HasNoSlopeWhereBothEndsCoincide) {
  using F = RangeWithTimeOffset<Motion2, Point2>;
  Jacobians<F> J;
  J.all.setConstant(NAN);
  EXPECT_DOUBLE_EQ((F{5, 0.5}(Motion2(0, 1, 0, 0), Point2(1, 0), Scalar(1), &J))[0], -10);
  EXPECT_TRUE(J.all.isZero(0));
}

TEST(RangeTimeOffset, IsTheSameInEveryFrame) {
  std::mt19937_64 rng(3);
  const Pose3 T = testing::random_variable<Pose3>(rng), a = testing::random_variable<Pose3>(rng), b = testing::random_variable<Pose3>(rng);
  const AntennaRangeWithTimeOffset<Pose3, Pose3> range{3, 0.2, {0.3, 0.1, 0}, {0, 0.2, 0}, {2, 0.1, -1}};
  EXPECT_NEAR(range(a, b, Scalar(0.1))[0], range(T * a, T * b, Scalar(0.1))[0], 1e-10);
}

TEST(RangeTimeOffset, RefusesNumbersThatAreNone) {
  using F = AntennaRangeWithTimeOffset<Pose2, Point2>;
  EXPECT_THROW((F{1, 1, {0, 0}, {0, 0}, {NAN, 0}}).validate(), BadNumber);
  EXPECT_THROW((F{1, 1, {0, 0}, {1, 0}, {0, 0}}).validate(), BadNumber);
  EXPECT_THROW((F{1, 0, {0, 0}, {0, 0}, {0, 0}}).validate(), BadNumber);
  EXPECT_THROW((RangeWithTimeOffset<Motion2, Point2>{-1, 1}).validate(), BadNumber);
  EXPECT_NO_THROW((F{1, 1, {0.3, 0}, {0, 0}, {4, 0}}).validate());
}

// A robot drives a circle at 4 m/s among three anchors; its ranges are stamped 30 ms early.
TEST(RangeTimeOffset, AMovingRobotFindsTheOffset) {
  constexpr double radius = 8, speed = 4, dt = 0.1, tau = 0.03;
  const Agent A('A'), L('L');
  const Key offset('T', 0);
  const Vector<2> lever(0.3, 0.1), velocity = Vector<2>(speed, 0) + speed / radius * Vector<2>(-lever[1], lever[0]);
  const auto pose_at = [&](double t) {
    const double angle = speed / radius * t;
    return Pose2(radius * std::sin(angle), -radius * std::cos(angle), angle);
  };
  const Point2 anchors[]{{-12, -9}, {14, -6}, {1, 13}};
  std::mt19937_64 rng(5);
  std::normal_distribution<double> normal;
  Graph graph;
  Values values;
  values.insert(offset, Scalar(0));
  graph.add(Prior<Scalar>::from_sigmas(0, Vector<1>(0.1)), {offset});
  for (int l = 0; l < 3; ++l) {
    values.insert(L(l), anchors[l]);
    graph.fix(L(l));
  }
  for (int k = 0; k < 100; ++k) {
    values.insert(A(k), pose_at(k * dt).retract(Vector<3>(0.3 * normal(rng), 0.3 * normal(rng), 0.05 * normal(rng))));
    // Its pose by another sensor, whose clock is right: position and heading.
    graph.add(Prior<Pose2>::from_sigmas(pose_at(k * dt).retract(Vector<3>(0.05 * normal(rng), 0.05 * normal(rng), 0.01 * normal(rng))),
                                        {0.05, 0.05, 0.01}),
              {A(k)});
    for (int l = 0; l < 3; ++l) {
      const double measured = (pose_at(k * dt + tau) * lever - anchors[l].value).norm() + 0.05 * normal(rng);
      graph.add(AntennaRangeWithTimeOffset<Pose2, Point2>{measured, 0.05, lever, {0, 0}, velocity}, {A(k), L(l), offset});
    }
  }
  ASSERT_TRUE(Irls().solve(graph, values).usable());
  EXPECT_NEAR(values.at<Scalar>(offset).value, tau, 0.006);
}

}  // namespace
}  // namespace holdfast

namespace holdfast::testing {

template <class M, class B>
struct Sample<RangeWithTimeOffset<M, B>> : RandomVariables<RangeWithTimeOffset<M, B>> {
  static RangeWithTimeOffset<M, B> factor(std::mt19937_64& rng) { return {uniform(rng, 1, 20), uniform(rng, 0.5, 2)}; }
  static std::tuple<M, B, Scalar> variables(std::mt19937_64& rng) {
    auto x = RandomVariables<RangeWithTimeOffset<M, B>>::variables(rng);
    std::get<2>(x).value = uniform(rng, -0.2, 0.2);
    return x;
  }
};
template <class P, class B>
struct Sample<AntennaRangeWithTimeOffset<P, B>> : RandomVariables<AntennaRangeWithTimeOffset<P, B>> {
  static AntennaRangeWithTimeOffset<P, B> factor(std::mt19937_64& rng) {
    AntennaRangeWithTimeOffset<P, B> range{};
    range.distance = uniform(rng, 1, 20);
    range.sigma = uniform(rng, 0.5, 2);
    range.lever_a = random_vector<space_dim<P>>(rng, 0.3);
    range.lever_b.setZero();
    range.velocity = random_vector<space_dim<P>>(rng, 0.5);
    return range;
  }
};

}  // namespace holdfast::testing

HOLDFAST_CONFORMS(RangeWithTimeOffset<Motion2, Point2>, RangeWithTimeOffset<Accel3, Point3>, AntennaRangeWithTimeOffset<Pose2, Point2>,
                  AntennaRangeWithTimeOffset<Pose3, Point3>);
