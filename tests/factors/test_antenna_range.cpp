#include <gtest/gtest.h>

#include <holdfast/factors/antenna_range.hpp>
#include <holdfast/factors/between.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/graph/graph.hpp>
#include <holdfast/solvers/irls/irls.hpp>
#include <holdfast/testing.hpp>

#include "tests/conforms.hpp"

namespace holdfast {
namespace {

using OnRobot = AntennaRange<Pose2, Point2>;

TEST(AntennaRange, InNumbers) {
  // A robot at (1, 2) looking along y, its antenna 0.5 m ahead: at (1, 2.5). The anchor at (4, 6.5) is 5 m away.
  const OnRobot range{4.9, 0.1, {0.5, 0}, {0, 0}};
  EXPECT_NEAR(range(Pose2(1, 2, kPi / 2), Point2(4, 6.5))[0], 1, 1e-12);
  const AntennaRangeWithBias<Pose2, Point2> biased{5.2, 0.1, {0.5, 0}, {0, 0}};
  EXPECT_NEAR(biased(Pose2(1, 2, kPi / 2), Point2(4, 6.5), Scalar(0.15))[0], -0.5, 1e-12);
  EXPECT_NEAR(range.raw(Vector<1>(1))[0], 0.1, 1e-15);
}

TEST(AntennaRange, DelaysAndScaleInNumbers) {
  const Pose2 robot(1, 2, kPi / 2);
  const Point2 anchor(4, 6.5);  // 5 m from its antenna
  const Vector<2> lever(0.5, 0), none(0, 0);
  EXPECT_NEAR((AntennaRangeWithDelays<Pose2, Point2>{5.2, 0.1, lever, none}(robot, anchor, Scalar(0.2), Scalar(0.1)))[0], 1, 1e-12);
  EXPECT_NEAR((AntennaRangeWithScale<Pose2, Point2>{5.2, 0.1, lever, none}(robot, anchor, Scalar(0.02)))[0], -1, 1e-12);
  EXPECT_NEAR((AntennaRangeWithBiasAndScale<Pose2, Point2>{5.2, 0.1, lever, none}(robot, anchor, Scalar(0.15), Scalar(0.02)))[0], 0.5,
              1e-12);
}

TEST(AntennaRange, IsTheSameInEveryFrame) {
  std::mt19937_64 rng(3);
  const Pose3 T = testing::random_variable<Pose3>(rng), a = testing::random_variable<Pose3>(rng), b = testing::random_variable<Pose3>(rng);
  const AntennaRangeWithBiasAndScale<Pose3, Pose3> range{3, 0.2, {0.3, 0.1, 0}, {0, 0.2, 0}};
  EXPECT_NEAR(range(a, b, Scalar(0.1), Scalar(0.02))[0], range(T * a, T * b, Scalar(0.1), Scalar(0.02))[0], 1e-10);
}

TEST(AntennaRange, JacobiansInThePlaneAndInSpace) {
  std::mt19937_64 rng(1);
  using testing::random_variable;
  EXPECT_LT(testing::jacobian_error(AntennaRange<Pose2, Pose2>{3, 0.2, {0.5, -0.3}, {0.1, 0.7}}, random_variable<Pose2>(rng),
                                    random_variable<Pose2>(rng)),
            1e-8);
  EXPECT_LT(testing::jacobian_error(AntennaRangeWithBias<Pose3, Point3>{3, 0.2, {0.5, -0.3, 0.2}, {0, 0, 0}}, random_variable<Pose3>(rng),
                                    random_variable<Point3>(rng), Scalar(0.3)),
            1e-8);
}

TEST(AntennaRange, HasNoSlopeWhereTheAntennasCoincide) {
  Jacobians<OnRobot> J;
  J.all.setConstant(NAN);
  EXPECT_DOUBLE_EQ((OnRobot{5, 0.5, {1, 0}, {0, 0}}(Pose2(0, 0, 0), Point2(1, 0), &J))[0], -10);
  EXPECT_TRUE(J.all.isZero(0));
}

TEST(AntennaRange, RefusesALeverArmOfAPoint) {
  EXPECT_THROW((OnRobot{1, 1, {0, 0}, {0.1, 0}}).validate(), BadNumber);
  EXPECT_THROW((OnRobot{1, 1, {NAN, 0}, {0, 0}}).validate(), BadNumber);
  EXPECT_THROW((OnRobot{-1, 1, {0, 0}, {0, 0}}).validate(), BadNumber);
  EXPECT_NO_THROW((OnRobot{1, 1, {0.3, 0}, {0, 0}}).validate());
}

/// A robot on a figure of eight among four anchors of known places; its antenna is 0.3 m ahead, every anchor adds a bias of its own.
struct UwbRobot {
  static constexpr int kPoses = 120, kAnchors = 4;
  const Agent A{'A'}, L{'L'}, B{'B'};
  Graph graph;
  Values truth, start;

  explicit UwbRobot(double lever) {
    std::mt19937_64 rng(7);
    std::normal_distribution<double> normal;
    const Point2 anchors[kAnchors]{{-8, -8}, {8, -8}, {8, 8}, {-8, 8}};
    for (int l = 0; l < kAnchors; ++l) {
      truth.insert(L(l), anchors[l]);
      truth.insert(B(l), Scalar(0.15 + 0.02 * l));
      graph.fix(L(l));
      graph.add(Prior<Scalar>::from_sigmas(0, Vector<1>(1)), {B(l)});
    }
    for (int k = 0; k < kPoses; ++k) {
      const double t = 4 * kPi * k / kPoses;
      truth.insert(A(k), Pose2(5 * std::sin(t), 5 * std::sin(2 * t) / 2, std::atan2(std::cos(2 * t), std::cos(t))));
    }
    for (int k = 0; k < kPoses; ++k) {
      const Pose2& pose = truth.at<Pose2>(A(k));
      if (k > 0) {
        const Pose2 step = truth.at<Pose2>(A(k - 1)).inverse() * pose;
        const Vector<3> noise(0.01 * normal(rng), 0.01 * normal(rng), 0.002 * normal(rng));
        graph.add(Between<Pose2>::from_sigmas(step.retract(noise), {0.01, 0.01, 0.002}), {A(k - 1), A(k)});
      }
      for (int l = 0; l < kAnchors; ++l) {
        const double measured = (pose * Vector<2>(0.3, 0) - anchors[l].value).norm() + truth.at<Scalar>(B(l)).value + 0.02 * normal(rng);
        graph.add(AntennaRangeWithBias<Pose2, Point2>{measured, 0.02, {lever, 0}, {0, 0}}, {A(k), L(l), B(l)});
      }
    }
    start = truth;
    for (int k = 0; k < kPoses; ++k)
      start.update(A(k), truth.at<Pose2>(A(k)).retract(Vector<3>(normal(rng), normal(rng), 0.2 * normal(rng))));
    for (int l = 0; l < kAnchors; ++l) start.update(B(l), Scalar(0));
  }
};

TEST(AntennaRange, ARobotFindsTheBiasOfEveryAnchor) {
  UwbRobot with(0.3), without(0);
  Values x = with.start, y = without.start;
  ASSERT_TRUE(Irls().solve(with.graph, x).usable());
  ASSERT_TRUE(Irls().solve(without.graph, y).usable());
  double worst = 0, worst_without = 0;
  for (int k = 0; k < UwbRobot::kPoses; ++k) {
    worst = std::max(worst, (x.at<Pose2>(with.A(k)).p - with.truth.at<Pose2>(with.A(k)).p).norm());
    worst_without = std::max(worst_without, (y.at<Pose2>(with.A(k)).p - with.truth.at<Pose2>(with.A(k)).p).norm());
  }
  for (int l = 0; l < UwbRobot::kAnchors; ++l)
    EXPECT_NEAR(x.at<Scalar>(with.B(l)).value, with.truth.at<Scalar>(with.B(l)).value, 0.02) << l;
  EXPECT_LT(worst, 0.05);
  EXPECT_GT(worst_without, 0.2);  // the lever arm left out: the position is that of the antenna
  EXPECT_GT(without.graph.cost(y), 2 * with.graph.cost(x));
}

// Anchors surveyed to 0.5 m: with a prior each they are found along with the path and their biases.
TEST(AntennaRange, AnchorsAreFoundAsUnknowns) {
  UwbRobot robot(0.3);
  std::mt19937_64 rng(11);
  std::normal_distribution<double> normal;
  Values x = robot.start;
  robot.graph.add(Prior<Pose2>::from_sigmas(robot.truth.at<Pose2>(robot.A(0)), {0.01, 0.01, 0.001}), {robot.A(0)});
  double surveyed = 0, found = 0;
  for (int l = 0; l < UwbRobot::kAnchors; ++l) {
    robot.graph.unfix(robot.L(l));
    const Vector<2> truth = robot.truth.at<Point2>(robot.L(l)).value;
    const Point2 survey((truth + 0.5 * Vector<2>(normal(rng), normal(rng))).eval());
    surveyed = std::max(surveyed, (survey.value - truth).norm());
    robot.graph.add(Prior<Point2>::from_sigmas(survey, {0.5, 0.5}), {robot.L(l)});
    x.update(robot.L(l), survey);
  }
  ASSERT_TRUE(Irls().solve(robot.graph, x).usable());
  for (int l = 0; l < UwbRobot::kAnchors; ++l)
    found = std::max(found, (x.at<Point2>(robot.L(l)).value - robot.truth.at<Point2>(robot.L(l)).value).norm());
  EXPECT_GT(surveyed, 2 * found);
  EXPECT_LT(found, 0.25);  // its bias is sought as well, and an anchor is seen from one side only
}

}  // namespace
}  // namespace holdfast

namespace holdfast::testing {

template <class A, class B>
Vector<space_dim<A>> random_lever(std::mt19937_64& rng) {
  if constexpr (is_pose<A>) return random_vector<space_dim<A>>(rng, 0.3);
  return Vector<space_dim<A>>::Zero();
}
template <class A, class B>
struct Sample<AntennaRange<A, B>> : RandomVariables<AntennaRange<A, B>> {
  static AntennaRange<A, B> factor(std::mt19937_64& rng) {
    return {uniform(rng, 1, 20), uniform(rng, 0.5, 2), random_lever<A, B>(rng), random_lever<B, A>(rng)};
  }
};
template <class A, class B>
struct Sample<AntennaRangeWithBias<A, B>> : RandomVariables<AntennaRangeWithBias<A, B>> {
  static AntennaRangeWithBias<A, B> factor(std::mt19937_64& rng) {
    return {uniform(rng, 1, 20), uniform(rng, 0.5, 2), random_lever<A, B>(rng), random_lever<B, A>(rng)};
  }
};

template <class F, class A, class B>
F of_antennas(std::mt19937_64& rng) {
  return {uniform(rng, 1, 20), uniform(rng, 0.5, 2), random_lever<A, B>(rng), random_lever<B, A>(rng)};
}
template <class A, class B>
struct Sample<AntennaRangeWithDelays<A, B>> : RandomVariables<AntennaRangeWithDelays<A, B>> {
  static AntennaRangeWithDelays<A, B> factor(std::mt19937_64& rng) { return of_antennas<AntennaRangeWithDelays<A, B>, A, B>(rng); }
};
template <class A, class B>
struct Sample<AntennaRangeWithScale<A, B>> : RandomVariables<AntennaRangeWithScale<A, B>> {
  static AntennaRangeWithScale<A, B> factor(std::mt19937_64& rng) { return of_antennas<AntennaRangeWithScale<A, B>, A, B>(rng); }
};
template <class A, class B>
struct Sample<AntennaRangeWithBiasAndScale<A, B>> : RandomVariables<AntennaRangeWithBiasAndScale<A, B>> {
  static AntennaRangeWithBiasAndScale<A, B> factor(std::mt19937_64& rng) {
    return of_antennas<AntennaRangeWithBiasAndScale<A, B>, A, B>(rng);
  }
};

}  // namespace holdfast::testing

HOLDFAST_CONFORMS(AntennaRangeWithDelays<Pose2, Pose2>, AntennaRangeWithScale<Pose3, Point3>, AntennaRangeWithBiasAndScale<Pose2, Point2>,
                  AntennaRange<Pose2, Point2>, AntennaRange<Pose3, Pose3>, AntennaRangeWithBias<Pose2, Point2>,
                  AntennaRangeWithBias<Pose3, Point3>);
