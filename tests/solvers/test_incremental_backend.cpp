#include <gtest/gtest.h>

#include <holdfast/factors/between.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/solvers/table.hpp>
#include <holdfast/solvers/window/window.hpp>
#include <holdfast/testing.hpp>

namespace holdfast {
namespace {

using testing::uniform;

constexpr Agent x('x'), L('L');
const Vector<3> kSigmas(0.05, 0.05, 0.02);
constexpr double kAccuracy = 1e-5;  // of the cost: what relinearize = 1e-3 and a cost_tolerance of 1e-6 leave

Between<Pose2> between(const Pose2& measured) { return Between<Pose2>::from_sigmas(measured, kSigmas); }

double batch_cost(const Graph& graph, Values values) {
  Options options;
  options.cost_tolerance = 1e-13;
  return make_backend("irls", options)->solve(graph, values).cost;
}

/// A robot on a circle of 40 steps that measures the pose a lap ago, and ranges to two beacons under a robust loss.
class IncrementalBackendTest : public ::testing::Test {
 protected:
  IncrementalBackendTest() {
    values.insert(L(0), Point2(1, 2));
    values.insert(L(1), Point2(8, 9));
    for (int b = 0; b < 2; ++b) graph.add(Prior<Point2>::from_sigmas(values.at<Point2>(L(b)), Vector<2>(0.5, 0.5)), {L(b)});
    values.insert(x(0), Pose2());
    graph.add(Prior<Pose2>::from_sigmas(Pose2(), kSigmas), {x(0)});
  }
  Pose2 noisy(const Pose2& pose) { return pose * Pose2(uniform(rng, -0.08, 0.08), uniform(rng, -0.08, 0.08), uniform(rng, -0.03, 0.03)); }
  void grow() {
    const Pose2 step(1, 0, 2 * M_PI / 40);
    ++k;
    truth.push_back(truth.back() * step);
    const Pose2 measured = noisy(step);
    values.insert(x(k), values.at<Pose2>(x(k - 1)) * measured);
    graph.add(between(measured), {x(k - 1), x(k)});
    if (k >= 40) loops.push_back(graph.add(between(noisy(truth[k - 40].inverse() * truth[k])), {x(k - 40), x(k)}));
    const Point2 beacon = k % 2 == 0 ? Point2(1, 2) : Point2(8, 9);
    const double distance = (truth[k].p - beacon.position()).norm() + (k % 9 == 0 ? 4 : uniform(rng, -0.2, 0.2));
    ranges.push_back(graph.add(Range<Pose2, Point2>{distance, 0.1}, {x(k), L(k % 2)}, Cauchy{2}));
  }
  static bool went_on(const Summary& summary) { return std::string(summary.rule).find("linearised") != std::string::npos; }
  void expect_batch_answer(const char* after) {
    const Summary summary = backend->solve(graph, values);
    ASSERT_TRUE(summary.usable()) << after << ": " << summary.why();
    times_went_on += went_on(summary) ? 1 : 0;
    EXPECT_NEAR(summary.cost, graph.cost(values), 1e-12 * summary.cost) << after;
    EXPECT_NEAR(summary.cost, batch_cost(graph, values), kAccuracy * summary.cost + 1e-9) << after << ", step " << k;
  }

  std::mt19937_64 rng{1};
  Graph graph;
  Values values;
  std::vector<Pose2> truth{Pose2()};
  std::vector<FactorId> loops, ranges;
  std::unique_ptr<Backend> backend = make_backend("incremental");
  int k = 0, times_went_on = 0;
};

TEST_F(IncrementalBackendTest, AGraphThatGrowsIsTheBatchAnswerAtEveryStep) {
  while (k < 100) {
    grow();
    expect_batch_answer("grown");
  }
  EXPECT_EQ(times_went_on, 99);  // all but the first: not irls again and again
}

TEST_F(IncrementalBackendTest, WhateverChangesIsTakenIn) {
  const auto grow_by = [&](int steps) {
    for (int i = 0; i < steps; ++i) grow(), expect_batch_answer("grown");
  };
  grow_by(50);
  graph.remove(loops[3]);
  expect_batch_answer("a factor removed");
  grow_by(2);
  graph.set_loss(ranges[5], Huber{1});
  expect_batch_answer("another loss");
  grow_by(2);
  graph.set_weight(ranges[7], 25);
  expect_batch_answer("another weight");
  grow_by(2);
  graph.at<Range<Pose2, Point2>>(ranges[9]).distance += 0.3;
  expect_batch_answer("a number changed in place");
  grow_by(2);
  values.at<Pose2>(x(20)) = values.at<Pose2>(x(20)) * Pose2(0.3, -0.2, 0.1);
  expect_batch_answer("another start");
  grow_by(2);
  graph.fix(L(0));
  expect_batch_answer("a variable fixed");
  grow_by(2);
  graph.unfix(L(0));
  expect_batch_answer("and freed");
  grow_by(2);
  for (const FactorId id : graph.factors_on(x(k))) graph.remove(id);
  values.erase(x(k));
  --k;
  truth.pop_back();
  expect_batch_answer("the newest pose gone");
  grow_by(5);
}

TEST_F(IncrementalBackendTest, ADirectionThatNothingHoldsIsLeftToIrls) {
  for (int i = 0; i < 5; ++i) grow(), expect_batch_answer("grown");
  values.insert(L(2), Point2(3, 3));
  graph.add(Range<Pose2, Point2>{2, 0.1}, {x(k), L(2)});
  expect_batch_answer("one range to a new beacon");
  for (int i = 0; i < 5; ++i) grow(), expect_batch_answer("grown");
}

TEST_F(IncrementalBackendTest, ANumberThatIsNotFiniteFailsByNameAndLeavesTheValues) {
  for (int i = 0; i < 5; ++i) grow(), expect_batch_answer("grown");
  graph.at<Range<Pose2, Point2>>(ranges[2]).distance = std::numeric_limits<double>::quiet_NaN();
  const Pose2 before = values.at<Pose2>(x(3));
  const Summary summary = backend->solve(graph, values);
  EXPECT_FALSE(summary.usable());
  EXPECT_NE(summary.culprit.find("x3"), std::string::npos) << summary.why();
  EXPECT_EQ(before.p, values.at<Pose2>(x(3)).p);
}

TEST_F(IncrementalBackendTest, AnotherGraphIsAnotherProblem) {
  for (int i = 0; i < 5; ++i) grow(), expect_batch_answer("grown");
  Graph other;
  other.add(Prior<Pose2>::from_sigmas(Pose2(3, 4, 1), kSigmas), {x(0)});
  Values start;
  start.insert(x(0), Pose2());
  EXPECT_NEAR(backend->solve(other, start).cost, 0, 1e-12);
  EXPECT_NEAR(start.at<Pose2>(x(0)).p.x(), 3, 1e-6);
}

TEST(IncrementalBackend, AWindowWithoutEndOnItIsTheOneOnIrls) {
  const auto follow = [](const std::string& name) {
    WindowOptions options;
    options.backend = name;
    options.solver.cost_tolerance = 1e-12;
    Window window(options);
    std::mt19937_64 rng(3);
    window.add_state(x(0), 0, Pose2());
    window.add(Prior<Pose2>::from_sigmas(Pose2(), kSigmas), {x(0)});
    window.add_landmark(L(0), Point2(2, 5));
    window.add(Prior<Point2>::from_sigmas(Point2(2, 5), Vector<2>(0.3, 0.3)), {L(0)});
    Pose2 truth;
    for (int k = 1; k < 60; ++k) {
      const Pose2 step(0.5, 0, 0.1);
      truth = truth * step;
      window.add_state(x(k), k, x(k - 1), between(step * Pose2(uniform(rng, -0.05, 0.05), 0, uniform(rng, -0.02, 0.02))));
      window.add(Range<Pose2, Point2>{(truth.p - Vector<2>(2, 5)).norm() + uniform(rng, -0.1, 0.1), 0.1}, {x(k), L(0)}, Huber{2});
      EXPECT_TRUE(window.step(k).summary.usable());
    }
    return window.newest<Pose2>(x);
  };
  const Pose2 a = follow("incremental"), b = follow("irls");
  EXPECT_LT((a.p - b.p).norm(), 1e-4);
}

}  // namespace
}  // namespace holdfast
