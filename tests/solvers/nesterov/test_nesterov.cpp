#include <gtest/gtest.h>

#include <holdfast/solvers/nesterov/nesterov.hpp>

#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

Options traced() {
  Options options = to_the_bottom();
  options.trace = true;
  return options;
}

void expect_monotone(const Summary& summary) {
  ASSERT_FALSE(summary.trace.empty());
  EXPECT_DOUBLE_EQ(summary.trace.front().cost, summary.cost_first);
  for (std::size_t i = 1; i < summary.trace.size(); ++i) {
    ASSERT_TRUE(std::isfinite(summary.trace[i].cost)) << i;
    ASSERT_LE(summary.trace[i].cost, summary.trace[i - 1].cost) << i;
  }
}

void expect_convex_optimum(const SmallProblem& problem) {
  Values values = problem.start, reference = problem.start;
  const Summary summary = Nesterov(traced()).solve(problem.graph, values);
  EXPECT_EQ(summary.termination, Termination::converged) << summary.str();
  expect_monotone(summary);
  const double least = solve("irls", problem.graph, reference).cost;
  EXPECT_NEAR(problem.graph.cost(values), least, 1e-6 * least) << summary.str();
}

TEST(Nesterov, ReachesTheOptimumOfConvexProblems) {
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    SCOPED_TRACE(seed);
    for (const Loss& loss : {Loss(Squared{}), Loss(Huber{2}), Loss(Huber{0.5}), Loss(PseudoHuber{1})}) {
      SCOPED_TRACE(loss.str());
      expect_convex_optimum(range_balls<Point2>(seed, 12, loss));
      expect_convex_optimum(range_balls<Point3>(seed, 12, loss));
      expect_convex_optimum(tracking<Motion2>(seed, 40, 0.3, loss));
      expect_convex_optimum(tracking<Motion3>(seed, 25, 0.3, per_component(loss)));
    }
  }
}

TEST(Nesterov, BothMetricsReachTheSameOptimum) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const auto problem = range_balls<Point2>(seed, 40, Huber{2});
    double costs[2];
    for (const auto metric : {NesterovOptions::Metric::whole, NesterovOptions::Metric::chains}) {
      Options options = traced();
      options.max_iterations = 100000;
      Values values = problem.start;
      const Summary summary = Nesterov(options, {metric}).solve(problem.graph, values);
      EXPECT_EQ(summary.termination, Termination::converged) << summary.str();
      expect_monotone(summary);
      EXPECT_NEAR(summary.cost, problem.graph.cost(values), 1e-12 * summary.cost);
      costs[metric == NesterovOptions::Metric::whole] = summary.cost;
    }
    EXPECT_NEAR(costs[0], costs[1], 1e-6 * costs[1]) << seed;
  }
}

// Of a quadratic cost the whole of H is its curvature: the first step is the answer.
TEST(Nesterov, AQuadraticCostIsOneStepInTheWholeMetric) {
  constexpr Agent P('P');
  SmallProblem problem;
  for (int i = 0; i < 10; ++i) {
    problem.start.insert(P(i), Point2(0, 0));
    problem.graph.add(Prior<Point2>::from_sigmas(Point2(i, i * i), Vector<2>(1, 2)), {P(i)});
    if (i > 0) problem.graph.add(PositionStep<Point2, Point2>{0.3}, {P(i - 1), P(i)});
    if (i > 4) problem.graph.add(PositionStep<Point2, Point2>{0.3}, {P(i - 4), P(i)});
  }
  Values values = problem.start, reference = problem.start;
  Options options;
  options.max_iterations = 1;
  const double cost = Nesterov(options).solve(problem.graph, values).cost;
  EXPECT_NEAR(cost, solve("irls", problem.graph, reference).cost, 1e-9 * cost);
}

TEST(Nesterov, ReachesTheSameMinimumOnManifolds) {
  for (const std::uint64_t seed : {5, 6}) {
    const auto check = [](const SmallProblem& problem) {
      Values values = problem.start, reference = problem.start;
      const Summary summary = Nesterov(traced()).solve(problem.graph, values);
      expect_monotone(summary);
      const double least = solve("irls", problem.graph, reference).cost;
      EXPECT_NEAR(problem.graph.cost(values), least, 1e-6 * least) << summary.str();
    };
    check(slam<Pose2>(seed, 15, 0.1, Huber{2}));
    check(slam<Pose3>(seed, 15, 0.1, Huber{2}));
  }
}

TEST(Nesterov, NeverDivergesUnderAnyLossFromAnyStart) {
  for (int kind = 0; kind < kLossKinds; ++kind)
    for (const double far : {0.5, 5.0}) {
      SCOPED_TRACE(default_loss(kind).str() + " from " + std::to_string(far));
      for (const auto& problem : {slam<Pose2>(7, 10, 0.3, default_loss(kind), far), slam<Pose3>(8, 8, 0.3, default_loss(kind), far)}) {
        Values values = problem.start;
        Options options = traced();
        options.max_iterations = 300;
        const Summary summary = Nesterov(options).solve(problem.graph, values);
        ASSERT_TRUE(summary.usable()) << summary.str();
        expect_monotone(summary);
        EXPECT_LE(summary.cost, summary.cost_first);
        EXPECT_NEAR(summary.cost, problem.graph.cost(values), 1e-9 * summary.cost);
      }
    }
}

TEST(Nesterov, SaysSoWhenItHitsItsLimit) {
  const auto problem = slam<Pose2>(9, 60, 0.1, Squared{}, 0.5);
  Values values = problem.start;
  Options options = traced();
  options.max_iterations = 7;
  const Summary summary = Nesterov(options).solve(problem.graph, values);
  EXPECT_EQ(summary.termination, Termination::iteration_limit);
  EXPECT_EQ(summary.iterations, 7);
  EXPECT_LT(summary.cost, summary.cost_first);
  EXPECT_NEAR(summary.cost, problem.graph.cost(values), 1e-9 * summary.cost);
}

TEST(Nesterov, GivesTheSameBitsWithAnyNumberOfThreads) {
  for (const auto& problem : {slam<Pose2>(10, 300, 0.1, Huber{2}), range_balls<Point2>(10, 300, Huber{2})}) {
    Options options = to_the_bottom();
    options.max_iterations = 60;
    Values alone = problem.start;
    const Summary reference = Nesterov(options).solve(problem.graph, alone);
    for (const int threads : {2, 3}) {
      options.threads = threads;
      Values values = problem.start;
      const Summary summary = Nesterov(options).solve(problem.graph, values);
      EXPECT_TRUE(same_bits(alone, values)) << threads;
      EXPECT_EQ(summary.cost, reference.cost) << threads;
      EXPECT_EQ(summary.iterations, reference.iterations) << threads;
    }
  }
}

TEST(Nesterov, CopesWithScalesThatDiffer) {  // millimetres beside kilometres: what the preconditioner is for
  constexpr Agent P('P');
  Graph graph;
  Values values;
  for (int i = 0; i < 10; ++i) {
    values.insert(P(i), Point2(0, 0));
    const double sigma = std::pow(10.0, i % 5 - 2);
    graph.add(Prior<Point2>::from_sigmas(Point2(i, -i), Vector<2>(sigma, 3 * sigma)), {P(i)});
    if (i > 0) graph.add(PositionStep<Point2, Point2>{10}, {P(i - 1), P(i)}, Huber{2});
  }
  const SmallProblem problem{graph, values, values};
  expect_convex_optimum(problem);
}

}  // namespace
}  // namespace holdfast::testing
