// Measurements that say nothing of some directions, in every back-end: a GPS position as a prior on a pose, odometry of a robot that knows
// no height, roll and pitch. The answer is the one with almost no information (1e-9) in those directions.
#include <gtest/gtest.h>

#include <holdfast/factors/between.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/relative_point.hpp>
#include <holdfast/solvers/backend.hpp>
#include <holdfast/solvers/marginals.hpp>
#include <holdfast/solvers/outlier_report.hpp>

#include "tests/backends.hpp"
#include "tests/problems.hpp"

namespace holdfast {
namespace {

constexpr Agent A('A');
constexpr int kPoses = 6;

Pose3 truth(int i) { return {Vector<3>(2 * i, std::sin(i), 0.3 * i), so3::exp<double>(Vector<3>(0.05 * i, -0.04 * i, 0.4 * i))}; }

Matrix<6, 6> diagonal(const Vector<3>& translation, const Vector<3>& rotation) {
  Vector<6> all;
  all << translation, rotation;
  return all.asDiagonal();
}

/// The positions by GPS, roll and pitch by a level, the plane motion by odometry; `silence` is the information where they say nothing.
Graph planar_robot_in_space(double silence, const Loss& loss) {
  std::mt19937_64 rng(11);
  const double s = silence;
  Graph graph;
  for (int i = 0; i < kPoses; ++i) {
    const Pose3 gps = truth(i).retract(testing::random_vector<6>(rng, 0.1));
    graph.add(Prior<Pose3>::from_information(gps, diagonal({4, 4, 4}, {s, s, s})), {A(i)}, loss);
    const Pose3 level = truth(i).retract(testing::random_vector<6>(rng, 0.02));
    graph.add(Prior<Pose3>::from_information(level, diagonal({s, s, s}, {900, 900, s})), {A(i)});
    if (i == 0) continue;
    const Pose3 step = (truth(i - 1).inverse() * truth(i)).retract(testing::random_vector<6>(rng, 0.02));
    graph.add(Between<Pose3>::from_information(step, diagonal({100, 100, s}, {s, s, 400})), {A(i - 1), A(i)}, loss);
  }
  return graph;
}

Values start() {
  Values values;
  for (int i = 0; i < kPoses; ++i) values.insert(A(i), Pose3(truth(i).p + Vector<3>(0.5, -0.3, 0.2), truth(i).q));
  return values;
}

Options precise() {
  Options options;
  options.max_iterations = 3000;
  options.cost_tolerance = 1e-15;
  options.gradient_tolerance = 1e-10;
  return options;
}

TEST(PartialInformation, EveryBackendAnswersAsWithAlmostNone) {
  for (const Loss& loss : {Loss(Squared{}), Loss(Huber{2})}) {
    Values expected = start();
    ASSERT_TRUE(testing::solve("irls", planar_robot_in_space(1e-9, loss), expected, precise()).usable());
    for (const std::string& backend : testing::every_backend()) {
      SCOPED_TRACE(backend + " " + loss.str());
      const Graph graph = planar_robot_in_space(0, loss);
      Values values = start();
      const Summary summary = testing::solve(backend, graph, values, precise());
      ASSERT_TRUE(summary.usable()) << summary.str();
      for (int i = 0; i < kPoses; ++i)
        EXPECT_LT(expected.at<Pose3>(A(i)).local(values.at<Pose3>(A(i))).norm(), 1e-6) << i << " " << summary.str();
    }
  }
}

TEST(PartialInformation, MarginalsAreThoseOfAlmostNone) {
  Values values = start();
  const Graph graph = planar_robot_in_space(0, Squared{});
  ASSERT_TRUE(testing::solve("irls", graph, values, precise()).usable());
  const Marginals exact(graph, values), almost(planar_robot_in_space(1e-9, Squared{}), values);
  for (int i = 0; i < kPoses; ++i)
    EXPECT_LT((exact.covariance<Pose3>(A(i)) - almost.covariance<Pose3>(A(i))).norm(), 1e-7 * almost.covariance<Pose3>(A(i)).norm()) << i;
}

TEST(PartialInformation, WhatNothingMeasuresIsUnobservable) {
  Graph graph;
  graph.add(Prior<Pose3>::from_information(truth(0), diagonal({4, 4, 4}, {0, 0, 0})), {A(0)});
  Values values;
  values.insert(A(0), Pose3());
  EXPECT_FALSE(Marginals(graph, values).is_observable(A(0)));
  for (const std::string& backend : testing::every_backend()) {  // the position is found, the rotation stays
    Values answer = values;
    ASSERT_TRUE(testing::solve(backend, graph, answer, precise()).usable()) << backend;
    EXPECT_LT((answer.at<Pose3>(A(0)).p - truth(0).p).norm(), 1e-6) << backend;
    EXPECT_LT(answer.at<Pose3>(A(0)).q.angularDistance(Pose3().q), 1e-6) << backend;
  }
}

// The residual in metres: undone where W measures, 0 where it does not.
TEST(PartialInformation, IsReportedInUnitsWhereItMeasures) {
  Matrix<3, 3> information = Matrix<3, 3>::Zero();
  information(0, 0) = 4;
  information(2, 2) = 100;
  information(0, 2) = information(2, 0) = 3;
  Graph graph;
  graph.add(Prior<Point3>::from_information(Point3(1, 2, 3), information), {A(0)});
  Values values;
  values.insert(A(0), Point3(1.5, 7, 2.75));
  const auto report = outlier_report(graph, values);
  ASSERT_EQ(report.at(0).raw.size(), 3u);
  EXPECT_NEAR(report[0].raw[0], 0.5, 1e-14);
  EXPECT_EQ(report[0].raw[1], 0);
  EXPECT_NEAR(report[0].raw[2], -0.25, 1e-14);
}

}  // namespace
}  // namespace holdfast
