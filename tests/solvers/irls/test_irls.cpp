#include <gtest/gtest.h>

#include <holdfast/solvers/irls/irls.hpp>

#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

constexpr Agent A('A'), L('L');

Options with_threads(int threads, int iterations = 30) {
  Options options;
  options.threads = threads;
  options.max_iterations = iterations;
  options.cost_tolerance = 1e-12;
  options.trace = true;
  return options;
}

/// Summary and values of two solves agree bit by bit (but for the seconds).
void expect_same_solve(const Summary& a, const Values& x, const Summary& b, const Values& y) {
  EXPECT_TRUE(same_bits(x, y));
  EXPECT_EQ(a.cost_first, b.cost_first);
  EXPECT_EQ(a.cost, b.cost);
  EXPECT_EQ(a.gradient_norm, b.gradient_norm);
  EXPECT_EQ(a.iterations, b.iterations);
  ASSERT_EQ(a.trace.size(), b.trace.size());
  for (std::size_t i = 0; i < a.trace.size(); ++i) EXPECT_EQ(a.trace[i].cost, b.trace[i].cost) << i;
}

void expect_same_bits_with_any_threads(const SmallProblem& problem) {
  Values alone = problem.start;
  const Summary reference = Irls(with_threads(1)).solve(problem.graph, alone);
  ASSERT_TRUE(reference.usable()) << reference.str();
  for (const int threads : {2, 3, 5})
    for (int round = 0; round < 3; ++round) {
      SCOPED_TRACE(threads);
      Values values = problem.start;
      const Summary summary = Irls(with_threads(threads)).solve(problem.graph, values);
      expect_same_solve(reference, alone, summary, values);
    }
}

TEST(Irls, GivesTheSameBitsWithAnyNumberOfThreads) {
  expect_same_bits_with_any_threads(slam<Pose2>(1, 500, 0.1, Huber{2}));
  expect_same_bits_with_any_threads(slam<Pose3>(2, 300, 0.1, Cauchy{2}));
  expect_same_bits_with_any_threads(tracking<Motion3>(3, 600, 0.3, per_component(Huber{2})));  // all factors linear
  expect_same_bits_with_any_threads(range_balls<Point3>(4, 40, Huber{1}));
}

TEST(Irls, SolvesAgainLikeAFreshOne) {
  const auto problem = slam<Pose2>(5, 40, 0.1, Huber{2});
  Irls used(with_threads(1));
  Values first = problem.start;
  used.solve(problem.graph, first);
  for (int round = 0; round < 3; ++round) {
    Values again = problem.start, fresh = problem.start;
    const Summary a = used.solve(problem.graph, again);
    const Summary b = Irls(with_threads(1)).solve(problem.graph, fresh);
    expect_same_solve(a, again, b, fresh);
    EXPECT_TRUE(same_bits(again, first));
  }
}

/// A used solver after `change` solves like a fresh one.
template <class Change>
void expect_change_is_seen(SmallProblem problem, const Change& change) {
  Irls used(with_threads(2));
  Values before = problem.start;
  used.solve(problem.graph, before);
  change(problem);
  Values again = problem.start, fresh = problem.start;
  const Summary a = used.solve(problem.graph, again);
  const Summary b = Irls(with_threads(2)).solve(problem.graph, fresh);
  expect_same_solve(a, again, b, fresh);
  EXPECT_NEAR(a.cost, problem.graph.cost(again), 1e-10 * (1 + a.cost));
}

template <class Make>
void expect_every_change_is_seen(const Make& make) {
  expect_change_is_seen(make(), [](SmallProblem& p) { p.graph.add(Range<Pose2, Pose2>{1, 0.1}, {A(0), A(7)}, Huber{2}); });
  expect_change_is_seen(make(), [](SmallProblem& p) { p.graph.remove(p.graph.id_of(1, 3)); });
  expect_change_is_seen(make(), [](SmallProblem& p) { p.graph.fix(A(3)); });
  expect_change_is_seen(make(), [](SmallProblem& p) { p.start.insert(L(50), Point2(1, 2)); });
  expect_change_is_seen(make(), [](SmallProblem& p) {
    p.start.insert(A(100), Pose2(1, 2, 3));
    p.graph.add(Between<Pose2>::from_sigmas(Pose2(1, 0, 0), Vector<3>(0.1, 0.1, 0.1)), {A(3), A(100)});
  });
  expect_change_is_seen(make(), [](SmallProblem& p) {
    const Pose2 x = p.start.at<Pose2>(A(2));  // the same keys in other slots
    p.start.erase(A(2));
    p.start.insert(A(2), x);
  });
}

TEST(Irls, SeesEveryChangeOfStructure) {
  expect_every_change_is_seen([] { return slam<Pose2>(6, 12, 0.1, Huber{2}); });
}

TEST(Irls, SeesNumbersThatChangedInPlace) {
  expect_change_is_seen(slam<Pose2>(7, 12, 0.1),
                        [](SmallProblem& p) { p.graph.at<Between<Pose2>>(p.graph.id_of(1, 2)).measured = Pose2(2, 1, 0.5); });
  expect_change_is_seen(tracking<Motion2>(8, 12, 0.1, Huber{2}), [](SmallProblem& p) {  // linear: its Jacobians are kept
    const FactorId id = p.graph.id_of(0, 0);
    if (p.graph.batches()[0]->factor_type() == typeid(HuberMeasurement<Motion2>))
      p.graph.at<HuberMeasurement<Motion2>>(id).z += Vector<2>(5, 5);
  });
}

TEST(Irls, SeesANewNumberOfThreads) {
  const auto problem = slam<Pose2>(9, 30, 0.1, Huber{2});
  Irls solver(with_threads(1));
  Values alone = problem.start, shared = problem.start;
  const Summary a = solver.solve(problem.graph, alone);
  solver.options.threads = 3;
  expect_same_solve(a, alone, solver.solve(problem.graph, shared), shared);
}

TEST(Irls, SolvesALinearSquaredProblemInOneStep) {
  const auto problem = tracking<Motion2>(10, 20, 0.3, Squared{});
  Values values = problem.start;
  const Summary summary = Irls(to_the_bottom()).solve(problem.graph, values);
  EXPECT_EQ(summary.termination, Termination::converged);
  EXPECT_LE(summary.iterations, 2);
  EXPECT_LT(max_gradient(problem.graph, values), 1e-6);
}

TEST(Irls, EveryReweightingEndsInTheSameOptimumOfAConvexProblem) {
  for (const Loss& loss : {Loss(Huber{1}), per_component(Huber{1}), Loss(PseudoHuber{1}), Loss(Absolute{0.1})})
    for (const std::uint64_t seed : {1, 2, 3}) {
      SCOPED_TRACE(loss.str());
      std::vector<double> costs;
      for (const Reweighting reweighting : {Reweighting::automatic, Reweighting::irls, Reweighting::newton}) {
        const auto linear = tracking<Motion2>(seed, 30, 0.3, loss);
        const auto balls = range_balls<Point2>(seed, 8, loss);
        Options options = to_the_bottom();
        for (const SmallProblem* problem : {&linear, &balls}) {
          Values values = problem->start;
          ASSERT_TRUE(Irls(options, {reweighting}).solve(problem->graph, values).usable());
          costs.push_back(problem->graph.cost(values));
        }
      }
      for (std::size_t i = 2; i < costs.size(); ++i) EXPECT_NEAR(costs[i], costs[i % 2], 1e-6 * costs[i % 2]) << i;
    }
}

TEST(Irls, CostNeverRises) {
  for (const std::uint64_t seed : {11, 12, 13}) {
    for (const auto& problem : {slam<Pose3>(seed, 20, 0.3, Cauchy{1}, 0.8), tracking<Motion2>(seed, 30, 0.3, GemanMcClure{2}),
                                tracking<Motion2>(seed, 30, 0.3, Huber{1})}) {
      Values values = problem.start;
      Options options = to_the_bottom();
      options.trace = true;
      const Summary summary = Irls(options).solve(problem.graph, values);
      for (std::size_t i = 1; i < summary.trace.size(); ++i) EXPECT_LE(summary.trace[i].cost, summary.trace[i - 1].cost) << i;
      EXPECT_NEAR(summary.cost, problem.graph.cost(values), 1e-9 * summary.cost);
    }
  }
}

/// Rosenbrock's valley, once for every agent: r = (10 (y − x²), 1 − x), the minimum at (1, 1) behind a bend.
struct Valley {
  using Variables = variables<Point2>;
  static constexpr int residual_dim = 2;
  Vector<2> operator()(const Point2& p, Jacobians<Valley>* J = nullptr) const {
    const double x = p.value[0], y = p.value[1];
    if (J != nullptr) J->all << -20 * x, 10, -1, 0;
    return {10 * (y - x * x), 1 - x};
  }
};

TEST(Irls, FollowsABentValleyToItsEnd) {
  Graph graph;
  Values values;
  std::mt19937_64 rng(21);
  for (int i = 0; i < 50; ++i) {
    values.insert(L(i), Point2(uniform(rng, -3, 3), uniform(rng, -5, 5)));
    graph.add(Valley{}, {L(i)});
    if (i > 0) graph.add(Between<Point2>::from_sigmas(Point2(0, 0), Vector<2>(30, 30)), {L(i - 1), L(i)});
  }
  const Summary summary = Irls(with_threads(1, 60)).solve(graph, values);
  EXPECT_EQ(summary.termination, Termination::converged) << summary.str();
  EXPECT_LT(summary.cost, 1e-20);
  for (int i = 0; i < 50; ++i) EXPECT_LT((values.at<Point2>(L(i)).value - Vector<2>(1, 1)).norm(), 1e-9);
}

}  // namespace
}  // namespace holdfast::testing
