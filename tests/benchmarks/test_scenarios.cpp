#include <gtest/gtest.h>

#include <holdfast/benchmarks/scenarios/random.hpp>
#include <holdfast/benchmarks/scenarios/scenario.hpp>
#include <holdfast/benchmarks/suites/suites.hpp>
#include <holdfast/factors/huber_measurement.hpp>
#include <holdfast/factors/range_ball.hpp>
#include <holdfast/graph/check.hpp>
#include <holdfast/solvers/table.hpp>

namespace holdfast::bench {
namespace {

std::size_t factors_named(const Graph& graph, const std::string& name) {
  std::size_t count = 0;
  for (const auto& batch : graph.batches())
    if (batch->name() == name) count += batch->size();
  return count;
}

bool is_convex(const Graph& graph) {
  for (const auto& batch : graph.batches())
    if (!batch->is_convex()) return false;
  return true;
}

TEST(Random, IsTheSameEverywhere) {
  Random random(1);
  EXPECT_EQ(random.uniform(), static_cast<double>(2469588189546311528ull >> 11) * 0x1p-53);  // the standard fixes mt19937_64
  double sum = 0, squares = 0;
  constexpr int kDraws = 100000;
  for (int i = 0; i < kDraws; ++i) {
    const double x = random.normal();
    sum += x;
    squares += x * x;
  }
  EXPECT_NEAR(sum / kDraws, 0, 0.01);
  EXPECT_NEAR(squares / kDraws, 1, 0.02);
}

TEST(Unicycle, IsPaperAsWindow) {
  const Instance instance = unicycle({}, 1);
  EXPECT_EQ(factors_named(instance.graph, "HuberMeasurement"), 15u);
  EXPECT_EQ(factors_named(instance.graph, "WhiteAcceleration"), 14u);
  EXPECT_TRUE(is_convex(instance.graph));
  for (const auto& batch : instance.graph.batches())
    if (batch->name() == "HuberMeasurement") {
      EXPECT_EQ(batch->family(), per_component(Huber{2}));
    }
}

TEST(Unicycle, HasAFifthOfOutliersAllToOneSide) {
  UnicycleOptions options;
  options.states = 4000;
  const Instance instance = unicycle(options, 7);
  int outliers = 0;
  instance.graph.for_each_batch<HuberMeasurement<Motion2>>([&](const auto& batch) {
    for (int i = 0; i < batch.size(); ++i) {
      const Vector<2> error = batch.factors()[i](instance.truth.at<Motion2>(batch.keys(i)[0]));
      if (error.cwiseAbs().maxCoeff() < 10) continue;
      ++outliers;
      EXPECT_GT(error.minCoeff(), 34);
      EXPECT_LT(error.maxCoeff(), 76);
    }
  });
  EXPECT_NEAR(outliers / 4000.0, 0.2, 0.02);
}

TEST(Unicycle, DrivesAtConstantSpeed) {
  const Instance instance = unicycle({}, 3);
  for (int k = 1; k < 15; ++k) {
    const auto &a = instance.truth.at<Motion2>(Key('A', k - 1)), &b = instance.truth.at<Motion2>(Key('A', k));
    EXPECT_NEAR(a.derivative(1).norm(), 10, 1e-9);
    EXPECT_NEAR((b.position() - a.position()).norm(), 0.5, 1e-3);
  }
}

TEST(Swarm, HasEightNeighboursAndATenthAnchors) {
  const Instance instance = swarm(1000, 1);
  EXPECT_EQ(instance.start.size(), 1000u);
  EXPECT_EQ(factors_named(instance.graph, "Prior"), 100u);
  EXPECT_NEAR(2.0 * static_cast<double>(factors_named(instance.graph, "RangeBall")) / 1000, 8,
              1);  // a little less: the square has a border
  EXPECT_TRUE(is_convex(instance.graph));
}

TEST(Formation, LosesTheShareItWasAskedToLose) {
  const auto measurements = [](double lost) { return static_cast<double>(factors_named(formation(lost, 2).graph, "RangeBearingBall")); };
  EXPECT_EQ(measurements(0), 50 * (9 + 3));
  EXPECT_NEAR(measurements(0.5), 306, 6);  // every other one, beginning at step 1 or 2
  EXPECT_NEAR(measurements(0.2), 480, 40);
  EXPECT_TRUE(is_convex(formation(0.5, 2).graph));
}

TEST(Ring, HasFalseClosuresUnderItsLoss) {
  const Instance instance = ring(400, Cauchy{2}, 5);
  ASSERT_EQ(instance.start.size(), 400u);
  int closures = 0, wrong = 0;
  for (const auto& batch : instance.graph.batches()) {
    if (!(batch->family() == Loss(Cauchy{2}))) continue;
    for (int i = 0; i < batch->size(); ++i) {
      const Key a = batch->keys(i)[0], b = batch->keys(i)[1];
      ++closures;
      if (b.index() != a.index() + 200) ++wrong;
    }
  }
  EXPECT_EQ(closures, 40);
  EXPECT_NEAR(wrong, 12, 8);
}

TEST(Scenarios, AreSolvableAndTheSameForOneSeed) {
  for (const Case& one : scenario_cases(1)) {
    const Instance instance = one.make(), again = one.make();
    EXPECT_EQ(instance.graph.cost(instance.start), again.graph.cost(again.start)) << one.name;
    for (const Finding& finding : check(instance.graph, instance.start))
      EXPECT_TRUE(finding.kind == Finding::Kind::unconstrained_direction || finding.severity != Finding::Severity::error)
          << one.name << finding.text;
  }
  EXPECT_NE(swarm(20, 1).graph.cost(swarm(20, 1).start), swarm(20, 2).graph.cost(swarm(20, 2).start));
}

void expect_one_cost(const Instance& instance) {
  Options options;
  options.cost_tolerance = 1e-10;
  std::vector<double> costs;
  for (const char* name : {"irls", "nesterov"}) {
    Values values = instance.start;
    const Summary summary = make_backend(name, options)->solve(instance.graph, values);
    EXPECT_EQ(summary.termination, Termination::converged) << name << ' ' << summary.str();
    costs.push_back(summary.cost);
  }
  EXPECT_NEAR(costs[0], costs[1], 1e-6 * costs[0]);
}

TEST(Unicycle, HasOneCostForEveryBackEnd) {
  UnicycleOptions options;
  for (const double dt : {0.5, 0.05}) {  // at paper A's 0.05 s the motion is 800 times as stiff as a measurement
    options.dt = dt;
    expect_one_cost(unicycle(options, 1));
  }
}

TEST(Formation, HasOneCostForEveryBackEnd) { expect_one_cost(formation(0.5, 1)); }

// Convex, and from anywhere: a ball's residual is a vector, so that JᵀJ bends across a range as the cost does.
TEST(Swarm, HasOneCostForEveryBackEnd) {
  expect_one_cost(swarm(60, 1));
  expect_one_cost(swarm(60, 2));
}

}  // namespace
}  // namespace holdfast::bench
