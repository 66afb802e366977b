#include <gtest/gtest.h>

#include "tests/problems.hpp"

namespace holdfast {
namespace {

using testing::default_loss;
using testing::kLossKinds;

constexpr Agent A('A');

/// Central differences of Graph::cost over two steps, extrapolated.
std::vector<double> numeric_gradient(const Graph& graph, const Values& values) {
  const Resolved resolved(graph, values);
  std::vector<double> delta(resolved.tangent_dim(), 0.0), g(delta.size());
  Values moved = values;
  const auto cost_at = [&](std::size_t i, double h) {
    delta[i] = h;
    resolved.retract(values, delta.data(), moved);
    delta[i] = 0;
    return graph.cost(moved);
  };
  for (std::size_t i = 0; i < g.size(); ++i) {
    const auto slope = [&](double h) { return (cost_at(i, h) - cost_at(i, -h)) / (2 * h); };
    g[i] = (4 * slope(5e-5) - slope(1e-4)) / 3;
  }
  return g;
}

double largest(const std::vector<double>& v) {
  double most = 0;
  for (double x : v) most = std::max(most, std::abs(x));
  return most;
}

void expect_numeric(const Graph& graph, const Values& values) {
  const Gradient g = gradient(graph, values);
  const std::vector<double> numeric = numeric_gradient(graph, values);
  ASSERT_EQ(g.value.size(), numeric.size());
  for (std::size_t i = 0; i < numeric.size(); ++i) EXPECT_NEAR(g.value[i], numeric[i], 1e-7 * (1 + largest(numeric))) << i;
}

TEST(Gradient, IsTheSlopeOfTheCostUnderEveryLoss) {
  for (int kind = 0; kind < kLossKinds; ++kind)
    for (Loss loss : {default_loss(kind), per_component(default_loss(kind))}) {
      if (loss.kind == Loss::Kind::Absolute) loss.scale = 0.5;  // wide against the step of the differences
      SCOPED_TRACE(loss.str());
      const auto plane = testing::slam<Pose2>(1, 6, 0.3, loss, 0.3);
      expect_numeric(plane.graph, plane.start);
      const auto space = testing::slam<Pose3>(2, 6, 0.3, loss, 0.3);
      expect_numeric(space.graph, space.start);
    }
}

TEST(Gradient, LeavesFixedVariablesOut) {
  auto problem = testing::slam<Pose2>(3, 6, 0.3, Huber{2}, 0.3);
  const Gradient all = gradient(problem.graph, problem.start);
  problem.graph.fix(A(0));
  problem.graph.fix(A(3));
  expect_numeric(problem.graph, problem.start);
  const Gradient free = gradient(problem.graph, problem.start);
  EXPECT_EQ(free.value.size(), all.value.size() - 6);
  for (std::size_t k = 0; k < free.keys.size(); ++k) {
    EXPECT_NE(free.keys[k], A(0));
    const auto it = std::find(all.keys.begin(), all.keys.end(), free.keys[k]);
    ASSERT_NE(it, all.keys.end());
    EXPECT_EQ(free.value[free.offsets[k]], all.value[all.offsets[it - all.keys.begin()]]);
  }
}

TEST(Gradient, VanishesWhereEveryResidualIsZero) {
  const auto problem = testing::slam<Pose3>(4, 8, 0);
  EXPECT_LT(largest(gradient(problem.graph, problem.truth).value), 1e-11);
}

TEST(Gradient, IsLinearInTheWeights) {
  constexpr Key a('A', 0);
  Values values;
  values.insert(a, Point2(3, 1));
  const auto at = [&](double weight) {
    Graph graph;
    graph.add(Prior<Point2>::from_sigmas(Point2(0, 0), Vector<2>(1, 2)), {a}, Cauchy{1}, weight);
    return gradient(graph, values).value;
  };
  EXPECT_DOUBLE_EQ(at(5)[0], 5 * at(1)[0]);
  EXPECT_EQ(at(0), (std::vector<double>{0, 0}));
}

TEST(GradientEvaluator, HasTheSameBitsForAnyNumberOfThreads) {
  const auto problem = testing::slam<Pose2>(5, 900, 0.3, Huber{1}, 0.3);
  const Resolved resolved(problem.graph, problem.start);
  GradientEvaluator evaluate(problem.graph);
  std::vector<double> alone, shared;
  const double cost = evaluate(problem.graph, resolved, problem.start, alone);
  EXPECT_NEAR(cost, problem.graph.cost(problem.start), 1e-12 * cost);
  for (const int threads : {1, 2, 3, 5}) {
    ThreadPool pool(threads);
    EXPECT_EQ(evaluate(problem.graph, resolved, problem.start, shared, &pool), cost) << threads;
    EXPECT_EQ(shared, alone) << threads;
  }
}

}  // namespace
}  // namespace holdfast
