#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "tests/problems.hpp"

namespace holdfast {
namespace {

using ::testing::HasSubstr;

constexpr Agent A('A'), L('L');
using PoseRange = Range<Pose2, Point2>;

template <class E>
std::string message_of(const Graph& graph, const Values& values) {
  try {
    Resolved(graph, values);
  } catch (const E& error) {
    return error.what();
  }
  return "nothing was thrown";
}

TEST(Resolved, NamesTheFactorOfAKeyWithoutAValue) {
  Graph graph;
  graph.add(PoseRange{1, 1}, {A(3), L(0)});
  Values values;
  values.insert(A(3), Pose2());
  const std::string message = message_of<BadKey>(graph, values);
  for (const char* part : {"Range(A3, L0)", "L0", "Point2"}) EXPECT_THAT(message, HasSubstr(part));
}

TEST(Resolved, NamesTheFactorOfAWrongType) {
  Graph graph;
  graph.add(PoseRange{1, 1}, {A(3), L(0)});
  Values values;
  values.insert(A(3), Pose2());
  values.insert(L(0), Point3(0, 0, 0));
  const std::string message = message_of<BadType>(graph, values);
  for (const char* part : {"Range(A3, L0)", "L0", "Point2", "Point3"}) EXPECT_THAT(message, HasSubstr(part));
}

TEST(Resolved, EveryFreeVariableHasItsOwnPlaceInTheTangent) {
  const auto problem = testing::slam<Pose2>(1, 6, 0.1);
  Graph graph = problem.graph;
  graph.fix(A(2));
  graph.fix(Key('X', 9));  // in no factor: no matter
  Values values = problem.start;
  values.insert(L(99), Point2(0, 0));  // in no factor: no part of the problem
  const Resolved resolved(graph, values);
  std::vector<int> taken(resolved.tangent_dim(), 0);
  std::set<Key> keys;
  for (const Resolved::Variable& v : resolved.variables()) {
    keys.insert(v.key);
    EXPECT_EQ(v.offset < 0, v.key == A(2)) << v.key;
    EXPECT_EQ(values.slot(v.key).index, v.index);
    for (int c = 0; v.offset >= 0 && c < v.dim; ++c) ++taken[v.offset + c];
  }
  EXPECT_THAT(taken, ::testing::Each(1));
  EXPECT_EQ(resolved.tangent_dim(), 5 * 3 + 3 * 2);
  EXPECT_EQ(keys.count(L(99)), 0u);
  EXPECT_EQ(keys.size(), 9u);
}

TEST(Resolved, IndicesAreThoseOfTheKeys) {
  const auto problem = testing::slam<Pose3>(2, 7, 0.1);
  const Resolved resolved(problem.graph, problem.start);
  int residuals = 0;
  for (std::size_t b = 0; b < problem.graph.batches().size(); ++b) {
    const FactorBatch& batch = *problem.graph.batches()[b];
    residuals += batch.size() * batch.residual_dim();
    for (int i = 0; i < batch.size(); ++i)
      for (int k = 0; k < batch.arity(); ++k) {
        const std::size_t at = static_cast<std::size_t>(i) * batch.arity() + k;
        const Resolved::Variable& v = resolved.variables()[resolved.batches()[b].variable[at]];
        EXPECT_EQ(v.key, batch.keys(i)[k]);
        EXPECT_EQ(v.index, resolved.batches()[b].index[at]);
      }
  }
  EXPECT_EQ(resolved.residual_dim(), residuals);
}

TEST(Resolved, MatchesUntilAStructureChanges) {
  auto problem = testing::slam<Pose2>(3, 5, 0.1);
  const Resolved resolved(problem.graph, problem.start);
  EXPECT_TRUE(resolved.matches(problem.graph, problem.start));
  EXPECT_TRUE(resolved.matches(Graph(problem.graph), Values(problem.start)));
  problem.start.at<Pose2>(A(0)).p[0] += 1;
  EXPECT_TRUE(resolved.matches(problem.graph, problem.start));
  Values more = problem.start;
  more.insert(L(50), Point2(0, 0));
  EXPECT_FALSE(resolved.matches(problem.graph, more));
  problem.graph.fix(A(0));
  EXPECT_FALSE(resolved.matches(problem.graph, problem.start));
}

TEST(Resolved, RetractAndLocalAreInverse) {
  auto problem = testing::slam<Pose3>(4, 5, 0.1);
  problem.graph.fix(A(1));
  const Resolved resolved(problem.graph, problem.start);
  std::mt19937_64 rng(5);
  std::vector<double> delta(resolved.tangent_dim()), back(delta.size());
  for (double& d : delta) d = testing::uniform(rng, -0.8, 0.8);
  Values moved = problem.start;
  resolved.retract(problem.start, delta.data(), moved);
  resolved.local(problem.start, moved, back.data());
  for (std::size_t i = 0; i < delta.size(); ++i) EXPECT_NEAR(back[i], delta[i], 1e-14);
  EXPECT_EQ(problem.start.at<Pose3>(A(1)).local(moved.at<Pose3>(A(1))).norm(),
            problem.start.at<Pose3>(A(1)).local(problem.start.at<Pose3>(A(1))).norm());
}

TEST(Resolved, CostHasTheSameBitsForAnyNumberOfThreads) {
  std::mt19937_64 rng(6);
  Graph graph;
  Values values;
  for (int i = 0; i < 2000; ++i) values.insert(A(i), Point2(testing::random_vector<2>(rng, 10)));
  for (int i = 1; i < 2000; ++i) graph.add(Range<Point2, Point2>{3, 0.7}, {A(i - 1), A(i)}, Cauchy{1});
  const Resolved resolved(graph, values);
  const double alone = resolved.cost(graph, values);
  for (const int threads : {1, 2, 3, 5}) {
    ThreadPool pool(threads);
    EXPECT_EQ(resolved.cost(graph, values, &pool), alone) << threads;
  }
  EXPECT_EQ(graph.cost(values), alone);
}

TEST(Resolved, FindsTheFirstNonFiniteFactor) {
  Graph graph;
  Values values;
  for (int i = 0; i < 4; ++i) values.insert(A(i), Point2(i, 0));
  for (int i = 1; i < 4; ++i) graph.add(Range<Point2, Point2>{1, 1}, {A(i - 1), A(i)});
  EXPECT_EQ(Resolved(graph, values).first_non_finite(graph, values).text, "");
  values.at<Point2>(A(2)).value[1] = NAN;
  const std::string culprit = Resolved(graph, values).first_non_finite(graph, values).text;
  for (const char* part : {"Range(A1, A2)", "A1 = [1", "A2 = [2", "nan"}) EXPECT_THAT(culprit, HasSubstr(part));
}

TEST(Chunks, CoverEveryFactorOnce) {
  const auto problem = testing::slam<Pose2>(7, 30, 0.1);
  for (const int size : {1, 7, 1000}) {
    std::vector<int> next(problem.graph.batches().size(), 0);
    for (const Chunk& chunk : chunks_of(problem.graph, size)) {
      EXPECT_EQ(chunk.first, next[chunk.batch]);
      EXPECT_GT(chunk.last, chunk.first);
      EXPECT_LE(chunk.last - chunk.first, size);
      next[chunk.batch] = chunk.last;
    }
    for (std::size_t b = 0; b < next.size(); ++b) EXPECT_EQ(next[b], problem.graph.batches()[b]->size());
  }
}

}  // namespace
}  // namespace holdfast
