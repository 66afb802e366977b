#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <holdfast/solvers/linear/internal/block_cholesky.hpp>
#include <numeric>

#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A problem's normal equations in the order its symbolic phase chose.
struct System {
  Resolved resolved;
  std::vector<int> variable;
  Symbolic symbolic;
  NormalEquations normal;
  std::vector<double> damping;

  explicit System(const SmallProblem& problem)
      : resolved(problem.graph, problem.start),
        symbolic(analyze(block_graph(problem.graph, resolved, variable))),
        normal(problem.graph, resolved, order()),
        damping(resolved.tangent_dim(), 0.5) {
    normal.linearize(problem.graph, resolved, problem.start, Curvature::irls);
  }
  std::vector<int> order() const {
    std::vector<int> all;
    for (int node : symbolic.order) all.push_back(variable[node]);
    return all;
  }
  MatrixXd dense() const {
    const BlockPattern& p = normal.pattern();
    MatrixXd H = MatrixXd::Zero(p.scalar_size(), p.scalar_size());
    for (int c = 0; c < p.size(); ++c)
      for (int k = p.column_begin[c]; k < p.column_begin[c + 1]; ++k)
        H.block(p.offsets[p.rows[k]], p.offsets[c], p.dims[p.rows[k]], p.dims[c]) =
            Eigen::Map<const MatrixXd>(&normal.H()[p.block_begin[k]], p.dims[p.rows[k]], p.dims[c]);
    MatrixXd full = H.selfadjointView<Eigen::Lower>();
    full.diagonal() += Eigen::Map<const VectorXd>(damping.data(), full.rows());
    return full;
  }
};

void expect_solves(const SmallProblem& problem) {
  System system(problem);
  BlockCholesky cholesky(system.symbolic, system.normal.pattern());
  ASSERT_TRUE(cholesky.factor(system.normal.H(), system.damping));
  const int n = system.resolved.tangent_dim();
  std::mt19937_64 rng(1);
  std::vector<double> b(n), x(n);
  for (double& v : b) v = uniform(rng, -1, 1);
  cholesky.solve(b, x);
  const VectorXd expected = system.dense().llt().solve(Eigen::Map<const VectorXd>(b.data(), n));
  EXPECT_LT((Eigen::Map<const VectorXd>(x.data(), n) - expected).norm(), 1e-9 * expected.norm());
}

TEST(BlockCholesky, SolvesLikeADenseOne) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    expect_solves(slam<Pose2>(seed, 40, 0.1));
    expect_solves(slam<Pose3>(seed, 25, 0.1));
    expect_solves(tracking<Motion2>(seed, 60, 0.1, Huber{2}));
    expect_solves(range_balls<Point3>(seed, 15, Huber{2}));  // a full matrix
    expect_solves(range_balls<Point2>(seed, 1, Huber{2}));   // a single block
  }
}

TEST(BlockCholesky, GivesTheSameBitsWithAnyNumberOfThreads) {
  for (const auto& problem : {slam<Pose2>(4, 800, 0.1), slam<Pose3>(5, 200, 0.1), range_balls<Point3>(6, 60, Squared{})}) {
    System system(problem);
    const int n = system.resolved.tangent_dim();
    std::vector<double> b(n, 1.0), alone(n), shared(n);
    BlockCholesky cholesky(system.symbolic, system.normal.pattern());
    ASSERT_TRUE(cholesky.factor(system.normal.H(), system.damping));
    cholesky.solve(b, alone);
    for (const int threads : {1, 2, 3, 5}) {
      ThreadPool pool(threads);
      for (int round = 0; round < 5; ++round) {
        ASSERT_TRUE(cholesky.factor(system.normal.H(), system.damping, &pool));
        cholesky.solve(b, shared);
        EXPECT_EQ(shared, alone) << threads;
      }
    }
  }
}

TEST(BlockCholesky, SaysWhenAMatrixIsNotPositiveDefinite) {
  System system(slam<Pose2>(7, 30, 0.1));
  BlockCholesky cholesky(system.symbolic, system.normal.pattern());
  std::vector<double> against = system.damping;
  for (const double bad : {-1e9, static_cast<double>(NAN)})
    for (const std::size_t i : {std::size_t{0}, against.size() / 2, against.size() - 1}) {
      against = system.damping;
      against[i] = bad;
      EXPECT_FALSE(cholesky.factor(system.normal.H(), against)) << i << " " << bad;
      ThreadPool pool(2);
      EXPECT_FALSE(cholesky.factor(system.normal.H(), against, &pool)) << i << " " << bad;
    }
  EXPECT_TRUE(cholesky.factor(system.normal.H(), system.damping));  // and is none the worse for it
}

TEST(Symbolic, OrdersEveryNodeOnceAndItsTreeUpwards) {
  const auto problem = slam<Pose2>(8, 120, 0.1);
  const System system(problem);
  std::vector<int> sorted = system.symbolic.order;
  std::sort(sorted.begin(), sorted.end());
  std::vector<int> all(sorted.size());
  std::iota(all.begin(), all.end(), 0);
  EXPECT_EQ(sorted, all);
  int next = 0;
  for (std::size_t s = 0; s < system.symbolic.supernodes.size(); ++s) {
    const Symbolic::Supernode& node = system.symbolic.supernodes[s];
    EXPECT_EQ(node.first, next);
    EXPECT_GT(node.last, node.first);
    EXPECT_GE(node.n, node.k);
    if (node.parent >= 0) {
      EXPECT_GT(node.parent, static_cast<int>(s));
    }
    next = node.last;
  }
  EXPECT_EQ(next, static_cast<int>(all.size()));
}

/// Nodes of one unknown each, tied by these pairs.
BlockGraph graph_of(int nodes, const std::vector<std::pair<int, int>>& edges) {
  std::vector<std::vector<int>> neighbours(nodes);
  for (const auto& [a, b] : edges) {
    neighbours[a].push_back(b);
    neighbours[b].push_back(a);
  }
  BlockGraph graph;
  graph.dims.assign(nodes, 1);
  for (std::vector<int>& some : neighbours) {
    std::sort(some.begin(), some.end());
    graph.neighbours.insert(graph.neighbours.end(), some.begin(), some.end());
    graph.begin.push_back(static_cast<int>(graph.neighbours.size()));
  }
  return graph;
}

TEST(MinimumDegree, EliminatesAHubLast) {  // first, it would tie all the others to each other
  std::vector<std::pair<int, int>> edges;
  for (int i = 1; i < 200; ++i) edges.emplace_back(0, i);
  const std::vector<int> order = minimum_degree_order(graph_of(200, edges));
  EXPECT_GE(std::find(order.begin(), order.end(), 0) - order.begin(), 198);
}

TEST(MinimumDegree, FindsTheChainInShuffledNumbers) {
  std::vector<int> name(400), in_line(400);
  std::iota(in_line.begin(), in_line.end(), 0);
  name = in_line;
  std::mt19937_64 rng(10);
  std::shuffle(name.begin(), name.end(), rng);
  std::vector<std::pair<int, int>> line, shuffled;
  for (int i = 1; i < 400; ++i) {
    line.emplace_back(i - 1, i);
    shuffled.emplace_back(name[i - 1], name[i]);
  }
  const BlockGraph graph = graph_of(400, shuffled);
  EXPECT_LT(analyze(graph, minimum_degree_order(graph)).flops, 5 * analyze(graph_of(400, line), in_line).flops);
}

TEST(Orderings, ArePermutations) {
  const auto problem = slam<Pose3>(9, 60, 0.1);
  const Resolved resolved(problem.graph, problem.start);
  std::vector<int> variable;
  const BlockGraph blocks = block_graph(problem.graph, resolved, variable);
  for (std::vector<int> order : {minimum_degree_order(blocks), nested_dissection_order(blocks)}) {
    if (order.empty()) continue;  // without METIS
    std::sort(order.begin(), order.end());
    for (int i = 0; i < blocks.size(); ++i) ASSERT_EQ(order[i], i);
    EXPECT_EQ(static_cast<int>(order.size()), blocks.size());
  }
}

}  // namespace
}  // namespace holdfast::testing
