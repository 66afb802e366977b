#include <gtest/gtest.h>

#include <holdfast/common/metrics.hpp>
#include <holdfast/common/run.hpp>
#include <holdfast/factors/between.hpp>
#include <holdfast/factors/range.hpp>
#include <random>

namespace holdfast::common {
namespace {

constexpr Agent A('A'), B('B');

Values curve() {
  Values values;
  for (int k = 0; k < 10; ++k) values.insert(A(k), Pose2(k, 0.1 * k * k, 0.2 * k));
  for (int k = 0; k < 10; ++k) values.insert(B(k), Pose2(-k, 3 + k, 0.0));
  return values;
}

TEST(PositionError, OfARigidlyMovedTrajectoryIsZeroOnlyAligned) {
  const Values truth = curve();
  const Pose2 motion(5, -2, 2.5);
  Values moved;
  for (Key key : truth.keys()) moved.insert(key, motion * truth.at<Pose2>(key));
  const auto error = position_error(truth, moved);
  ASSERT_TRUE(error);
  EXPECT_LT(error->ate_rmse, 1e-12);
  EXPECT_GT(error->rmse, 1);
  EXPECT_EQ(error->positions, 20u);
}

TEST(PositionError, OfARigidlyMovedTrajectoryInSpaceIsZero) {
  std::mt19937_64 rng(3);
  std::normal_distribution<double> normal;
  Values truth, moved;
  const Pose3 motion = Pose3{}.retract(Vector<6>(1, -2, 3, 0.4, -1.2, 0.9));
  for (int k = 0; k < 12; ++k) {
    Vector<6> delta;
    for (int i = 0; i < 6; ++i) delta[i] = normal(rng);
    const Pose3 pose = Pose3{}.retract(delta);
    truth.insert(A(k), pose);
    moved.insert(A(k), motion * pose);
  }
  EXPECT_LT(position_error(truth, moved)->ate_rmse, 1e-12);
}

TEST(PositionError, DoesNotMirror) {
  const Values truth = curve();
  Values mirrored;
  for (Key key : truth.keys()) {
    const Pose2 pose = truth.at<Pose2>(key);
    mirrored.insert(key, Pose2(pose.p[0], -pose.p[1], 0));
  }
  EXPECT_GT(position_error(truth, mirrored)->ate_rmse, 0.5);
}

TEST(PositionError, HasOneMotionForAllAgents) {
  const Values truth = curve();
  Values parted;
  for (Key key : truth.keys()) parted.insert(key, key.agent() == 'A' ? Pose2(100, 0, 0) * truth.at<Pose2>(key) : truth.at<Pose2>(key));
  EXPECT_GT(position_error(truth, parted)->ate_rmse, 20);
}

TEST(PositionError, IsWhatTheHandSays) {  // off by (±1) along x: no motion takes that away
  Values truth, estimate;
  for (int k = 0; k < 4; ++k) {
    truth.insert(A(k), Point2(k < 2 ? 0.0 : 10.0, k % 2));
    estimate.insert(A(k), Point2(k < 2 ? -1.0 : 11.0, k % 2));
  }
  const auto error = position_error(truth, estimate);
  EXPECT_NEAR(error->ate_rmse, 1, 1e-12);
  EXPECT_NEAR(error->rmse, 1, 1e-12);
}

TEST(PositionError, IsAbsentWithoutTruth) {
  EXPECT_FALSE(position_error(Values{}, curve()));
  Values other;
  other.insert(Key('C', 0), Pose2{});
  EXPECT_FALSE(position_error(other, curve()));
}

TEST(PositionError, OfOnePositionIsZeroAligned) {
  Values truth, estimate;
  truth.insert(A(0), Point2(1.0, 2.0));
  estimate.insert(A(0), Point2(4.0, 6.0));
  EXPECT_NEAR(position_error(truth, estimate)->ate_rmse, 0, 1e-12);
  EXPECT_NEAR(position_error(truth, estimate)->rmse, 5, 1e-12);
}

TEST(CountRejected, CountsThoseWhoseWeightIsBelowAHalf) {
  Graph graph;
  Values values;
  values.insert(A(0), Point2(0.0, 0.0));
  values.insert(A(1), Point2(3.0, 4.0));
  for (double distance : {5.0, 8.9, 9.1, 0.5})  // Huber 2: weight 2/|r| is a half at |r| = 4
    graph.add(Range<Point2, Point2>{distance, 1.0}, {A(0), A(1)}, Huber{2});
  graph.add(Range<Point2, Point2>{500.0, 1.0}, {A(0), A(1)});                     // squared rejects nothing
  graph.add(Range<Point2, Point2>{0.5, 1.0}, {A(0), A(1)}, one_sided(Huber{2}));  // too short: trusted
  graph.add(Between<Point2>::from_sigmas(Point2(90.0, 0.0), Vector<2>(1, 1)), {A(0), A(1)}, Huber{2});
  const RejectedCount count = count_rejected(graph, values);
  EXPECT_EQ(count.ranges, 6u);
  EXPECT_EQ(count.rejected_ranges, 2u);
  EXPECT_EQ(count.judged, 6u);  // without the squared one, with the relative position
  EXPECT_EQ(count.rejected, 3u);
}

TEST(Median, IsInTheMiddle) {
  EXPECT_EQ(median({3, 1, 2}), 2);
  EXPECT_EQ(median({4, 1, 2, 3}), 2.5);
  EXPECT_TRUE(std::isnan(median({})));
}

TEST(Percentile, IsTheLeastThat95Of100DoNotExceed) {
  std::vector<double> numbers;
  for (int i = 100; i >= 1; --i) numbers.push_back(i);
  EXPECT_EQ(percentile_95(numbers), 95);
  EXPECT_EQ(percentile_95({1, 2, 3, 4, 5, 6, 7, 8, 9, 10}), 10);
  EXPECT_EQ(percentile_95({7}), 7);
  EXPECT_TRUE(std::isnan(percentile_95({})));
}

}  // namespace
}  // namespace holdfast::common
