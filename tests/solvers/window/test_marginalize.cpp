#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <holdfast/graph/check.hpp>
#include <holdfast/solvers/marginals.hpp>
#include <holdfast/solvers/window/marginalize.hpp>

#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

constexpr Agent A('A'), B('B'), L('L'), T('T');

/// Both problems solved to the bottom: the same estimate and covariance of every variable of the smaller one.
void expect_same_answer(const SmallProblem& full, const Graph& graph, Values start, const std::string& backend, double tolerance) {
  Values all = full.start;
  ASSERT_TRUE(solve("irls", full.graph, all).usable());
  const Summary summary = solve(backend, graph, start);
  ASSERT_TRUE(summary.usable()) << summary.str();
  Values rest = all;
  for (Key key : all.keys())
    if (!start.contains(key)) rest.erase(key);
  EXPECT_LT(largest_difference(start, rest), tolerance) << backend;
  const Marginals before(full.graph, all), after(graph, start);
  for (Key key : start.keys()) {
    const std::vector<double> C = before.covariance(key), D = after.covariance(key);
    double scale = 0;
    for (double c : C) scale = std::max(scale, std::abs(c));
    for (std::size_t i = 0; i < C.size(); ++i) EXPECT_NEAR(C[i], D[i], tolerance * scale) << key;
  }
}

TEST(Marginalize, OfALinearSquaredProblemChangesNothing) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const SmallProblem full = tracking<Motion2>(seed, 30, 0.1, Squared{});
    Graph graph = full.graph;
    Values values = full.start;  // anywhere: the problem is quadratic
    std::vector<Key> keys;
    for (int k : {0, 1, 2, 3, 17, 16, 9, 20}) keys.push_back(T(k));
    marginalize(graph, values, keys);
    EXPECT_EQ(values.size(), 22u);
    for (const std::string& backend : backend_names())
      if (backend == "irls" || backend == "ceres") expect_same_answer(full, graph, values, backend, 1e-9);
  }
}

TEST(Marginalize, AccountsForTheWholeCost) {
  const SmallProblem full = tracking<Motion2>(4, 12, 0.1, Huber{2});
  Values values = full.start;
  solve("irls", full.graph, values);
  Graph graph = full.graph;
  marginalize(graph, values, {T(0), T(1), T(2)});
  double constant = 0;
  for (const auto& batch : graph.batches())
    if (const auto* prior = dynamic_cast<const LinearPriorBatch*>(batch.get())) constant += prior->size() > 0 ? prior->prior().constant : 0;
  Values all = full.start;
  const double before = solve("irls", full.graph, all).cost;
  EXPECT_NEAR(before, graph.cost(values) + constant, 1e-9 * before);
  EXPECT_GT(constant, 0);
}

// Three readings of A0, at 1, 2 and 6, and B0 beside A0: the readings' mean is 3, and what they differ costs ½ (4 + 1 + 9), wherever B0 is.
TEST(Marginalize, KeepsWhatTheReadingsOfOneVariableCostAmongThemselves) {
  Graph graph;
  Values values;
  values.insert(A(0), Point2(10, -3));  // linear: anywhere
  values.insert(B(0), Point2(5, 0));
  for (const double x : {1.0, 2.0, 6.0}) graph.add(Prior<Point2>::from_sigmas(Point2(x, 0), Vector<2>(1, 1)), {A(0)});
  graph.add(Between<Point2>::from_sigmas(Point2(0, 0), Vector<2>(1, 1)), {A(0), B(0)});
  marginalize(graph, values, {A(0)});
  const auto& prior = dynamic_cast<const LinearPriorBatch&>(*graph.batches().back()).prior();
  EXPECT_NEAR(prior.constant, 7, 1e-12);
  EXPECT_NEAR(graph.cost(values), 1.5, 1e-12);  // ½ 2² / (1/3 + 1)
}

template <class V>
void expect_pose_graph_keeps_its_answer(const Loss& loss) {
  const SmallProblem full = slam<V>(5, 25, 0.05, loss);
  Values values = full.start;
  ASSERT_TRUE(solve("irls", full.graph, values).usable());
  Graph graph = full.graph;
  const Values answer = values;
  marginalize(graph, values, {A(0), A(1), A(2), A(7), L(1)});
  EXPECT_FALSE(has_errors(check(graph, values)));
  EXPECT_LT(max_gradient(graph, values), 1e-5);  // linearised at the answer: it stays the answer
  SmallProblem at_the_answer{full.graph, full.truth, answer};
  for (const std::string& backend : backend_names())
    if (backend == "irls" || backend == "ceres") expect_same_answer(at_the_answer, graph, values, backend, 1e-6);
}

TEST(Marginalize, KeepsTheAnswerOfAPoseGraph) {
  expect_pose_graph_keeps_its_answer<Pose2>(Squared{});
  expect_pose_graph_keeps_its_answer<Pose3>(Squared{});
  expect_pose_graph_keeps_its_answer<Pose2>(Huber{1});
  expect_pose_graph_keeps_its_answer<Pose3>(Cauchy{1});
}

TEST(Marginalize, NesterovMinimisesAPriorToo) {
  SmallProblem full = range_balls<Point2>(3, 8, Squared{});
  solve("irls", full.graph, full.start);
  Graph graph = full.graph;
  Values values = full.start;
  marginalize(graph, values, {Agent('P')(0), Agent('P')(3)});
  const double best = graph.cost(values);
  std::mt19937_64 rng(1);
  values = perturbed(graph, values, 0.1, rng);
  const Summary summary = solve("nesterov", graph, values);
  EXPECT_NEAR(summary.cost, best, 1e-6 * best) << summary.str();
}

TEST(Marginalize, InventsNothingWhereNothingIsKnown) {
  Graph graph;  // B1 is seen from A0 by a range alone: no one knows in which direction
  Values values;
  values.insert(A(0), Point2(0, 0));
  values.insert(B(0), Point2(3, 4));
  values.insert(B(1), Point2(3, 5));
  graph.add(Prior<Point2>::from_sigmas(Point2(0, 0), {0.1, 0.1}), {A(0)});
  graph.add(Range<Point2, Point2>{5, 0.5}, {A(0), B(0)});
  marginalize(graph, values, {A(0)});
  ASSERT_EQ(graph.size(), 1u);
  const auto& prior = dynamic_cast<const LinearPriorBatch&>(*graph.batches().back()).prior();
  EXPECT_EQ(prior.keys, std::vector<Key>{B(0)});
  EXPECT_EQ(prior.rows, 1);  // along the line of sight; 0.1² of A0 and 0.5² of the range
  const Vector<2> along(0.6, 0.8), across(-0.8, 0.6);
  const Vector<2> row(prior.A[0], prior.A[1]);
  EXPECT_NEAR(std::abs(row.dot(along)), 1 / std::sqrt(0.26), 1e-12);
  EXPECT_NEAR(row.dot(across), 0, 1e-12);

  marginalize(graph, values, {B(0)});  // the last of its kind: nothing is left to tell anyone
  EXPECT_EQ(graph.size(), 0u);
  EXPECT_EQ(values.keys(), std::vector<Key>{B(1)});
}

TEST(Marginalize, OfAGraphWithoutAReferenceLeavesItFree) {
  SmallProblem chain;
  for (int k = 0; k < 6; ++k) {
    chain.start.insert(A(k), Pose2(k, 0.1 * k, 0.1 * k));
    if (k > 0) chain.graph.add(Between<Pose2>::from_sigmas(Pose2(1, 0, 0.1), {1e-3, 1e-3, 1e-4}), {A(k - 1), A(k)});
  }
  marginalize(chain.graph, chain.start, {A(2), A(3)});
  EXPECT_EQ(chain.graph.size(), 3u);
  EXPECT_EQ(Marginals(chain.graph, chain.start).unobservable().size(), 4u);
}

TEST(Marginalize, KeepsSigmasTwelveDecadesApart) {
  Graph graph;
  Values values;
  for (int k = 0; k < 50; ++k) {
    values.insert(A(k), Point2(0, 0));
    if (k > 0) graph.add(PositionStep<Point2, Point2>{1e-6}, {A(k - 1), A(k)});
  }
  graph.add(Prior<Point2>::from_sigmas(Point2(0, 0), {1e6, 1e-3}), {A(0)});
  std::vector<Key> keys;
  for (int k = 0; k < 49; ++k) keys.push_back(A(k));
  marginalize(graph, values, keys);
  const auto C = Marginals(graph, values).covariance<Point2>(A(49));
  EXPECT_NEAR(C(0, 0), 1e12, 1e-3 * 1e12);
  EXPECT_NEAR(C(1, 1), 1e-6 + 49e-12, 1e-12);
}

TEST(Marginalize, TakesAFixedVariableAsAConstant) {
  SmallProblem full = slam<Pose2>(6, 10, 0.1);
  full.graph.fix(A(3));
  full.graph.fix(L(0));
  solve("irls", full.graph, full.start);
  Graph graph = full.graph;
  Values values = full.start;
  marginalize(graph, values, {A(3), A(4)});
  EXPECT_FALSE(graph.is_fixed(A(3)));
  for (const auto& batch : graph.batches()) {
    if (batch->factor_type() != typeid(LinearPrior)) continue;
    for (int k = 0; k < batch->size() * batch->arity(); ++k) EXPECT_NE(batch->keys(0)[k], L(0));
  }
  expect_same_answer(full, graph, values, "irls", 1e-6);
}

TEST(Marginalize, RefusesWhatItCannotKeep) {
  SmallProblem full = tracking<Motion2>(1, 5, 0.1, Squared{});
  Values values = full.start;
  EXPECT_THROW(marginalize(full.graph, values, {T(0), T(9)}), BadKey);
  EXPECT_EQ(values.size(), 5u);
  values.at<Motion2>(T(1)).value[0] = NAN;
  const std::size_t factors = full.graph.size();
  EXPECT_THROW(marginalize(full.graph, values, {T(0)}), BadNumber);
  EXPECT_EQ(full.graph.size(), factors);
}

TEST(Marginalize, LeavesNoEmptyBatchesBehind) {
  Graph graph;
  Values values;
  values.insert(A(0), Point2(0, 0));
  graph.add(Prior<Point2>::from_sigmas(Point2(0, 0), {1, 1}), {A(0)});
  for (int k = 1; k < 100; ++k) {
    values.insert(A(k), Point2(0, 0));
    graph.add(PositionStep<Point2, Point2>{1}, {A(k - 1), A(k)});
    marginalize(graph, values, {A(k - 1)});
  }
  EXPECT_LE(graph.batches().size(), 4u);
  EXPECT_NEAR(Marginals(graph, values).covariance<Point2>(A(99))(0, 0), 100, 1e-9);
}

}  // namespace
}  // namespace holdfast::testing
