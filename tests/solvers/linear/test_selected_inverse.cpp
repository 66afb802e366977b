// Blocks of H⁻¹ against the dense inverse, and which blocks a null vector moves.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <holdfast/solvers/linear/internal/selected_inverse.hpp>
#include <random>

namespace holdfast {
namespace {

using Eigen::MatrixXd;

/// A block matrix with these dimensions and pairs of neighbours, H = Σ J_eᵀ J_e over the edges (and the nodes named in `held`).
struct Problem {
  std::vector<int> dims;
  std::vector<std::pair<int, int>> edges;
  MatrixXd H;
  Symbolic symbolic;
  BlockPattern pattern;
  std::vector<double> values;

  Problem(std::vector<int> dims_of, std::vector<std::pair<int, int>> edges_of, const std::vector<int>& held, unsigned seed)
      : dims(std::move(dims_of)), edges(std::move(edges_of)) {
    std::mt19937_64 rng(seed);
    std::normal_distribution<double> normal;
    std::vector<int> offset{0};
    for (int d : dims) offset.push_back(offset.back() + d);
    H = MatrixXd::Zero(offset.back(), offset.back());
    // A difference of what two nodes have in common, as odometry is: the sum of both is free.
    for (const auto& [a, b] : edges) {
      const int m = std::min(dims[a], dims[b]);
      MatrixXd W(m, m), J = MatrixXd::Zero(m, offset.back());
      for (int i = 0; i < m * m; ++i) W.data()[i] = normal(rng);
      W += 3 * MatrixXd::Identity(m, m);
      J.middleCols(offset[a], m) = W;
      J.middleCols(offset[b], m) = -W;
      H += J.transpose() * J;
    }
    for (int node : held) H.block(offset[node], offset[node], dims[node], dims[node]) += 0.5 * MatrixXd::Identity(dims[node], dims[node]);
    order_blocks(offset);
  }

  int block_of(int node) const {
    return static_cast<int>(std::find(symbolic.order.begin(), symbolic.order.end(), node) - symbolic.order.begin());
  }
  MatrixXd dense_block(const MatrixXd& M, int a, int b) const {
    const auto begin = [&](int node) {
      int sum = 0;
      for (int i = 0; i < node; ++i) sum += dims[i];
      return sum;
    };
    return M.block(begin(a), begin(b), dims[a], dims[b]);
  }

 private:
  void order_blocks(const std::vector<int>& offset) {
    const int n = static_cast<int>(dims.size());
    BlockGraph graph;
    graph.dims = dims;
    std::vector<std::vector<bool>> near(n, std::vector<bool>(n, false));
    for (const auto& [a, b] : edges) near[a][b] = near[b][a] = true;
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j)
        if (near[i][j]) graph.neighbours.push_back(j);
      graph.begin.push_back(static_cast<int>(graph.neighbours.size()));
    }
    symbolic = analyze(graph);
    pattern.offsets = {0};
    pattern.column_begin = {0};
    pattern.block_begin = {0};
    for (int i = 0; i < n; ++i) {
      pattern.dims.push_back(dims[symbolic.order[i]]);
      pattern.offsets.push_back(pattern.offsets.back() + pattern.dims.back());
    }
    for (int c = 0; c < n; ++c) {
      for (int r = c; r < n; ++r) {
        const int a = symbolic.order[r], b = symbolic.order[c];
        if (r != c && !near[a][b]) continue;
        pattern.rows.push_back(r);
        const MatrixXd block = H.block(offset[a], offset[b], dims[a], dims[b]);
        values.insert(values.end(), block.data(), block.data() + block.size());
        pattern.block_begin.push_back(static_cast<int>(values.size()));
      }
      pattern.column_begin.push_back(static_cast<int>(pattern.rows.size()));
    }
  }
};

std::vector<std::pair<int, int>> chain_with_loops(int n) {
  std::vector<std::pair<int, int>> edges;
  for (int i = 1; i < n; ++i) edges.emplace_back(i - 1, i);
  for (int i = 0; i + 7 < n; i += 3) edges.emplace_back(i, i + 7);
  return edges;
}

TEST(SelectedInverse, IsTheDenseInverseBlockByBlock) {
  const int n = 30;
  std::vector<int> dims;
  for (int i = 0; i < n; ++i) dims.push_back(1 + i % 4);
  std::vector<int> held(n);
  for (int i = 0; i < n; ++i) held[i] = i;
  const Problem problem(dims, chain_with_loops(n), held, 1);
  const SelectedInverse inverse(problem.symbolic, problem.pattern, problem.values);
  const MatrixXd dense = problem.H.inverse();
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {  // also pairs that share no front
      const MatrixXd expected = problem.dense_block(dense, a, b);
      EXPECT_LT((inverse.block(problem.block_of(a), problem.block_of(b)) - expected).norm(), 1e-10 * (1 + expected.norm()))
          << a << ' ' << b;
      EXPECT_FALSE(inverse.is_free(problem.block_of(a)));
    }
}

// Two chains of points: the first is held, the second is not, and all of it can move.
TEST(SelectedInverse, NotesWhatANullVectorMovesAndAnswersForTheRest) {
  const int n = 12;
  std::vector<std::pair<int, int>> edges;
  for (int i = 1; i < n; ++i)
    if (i != 6) edges.emplace_back(i - 1, i);
  const Problem problem(std::vector<int>(n, 2), edges, {0}, 2);
  const SelectedInverse inverse(problem.symbolic, problem.pattern, problem.values);
  const MatrixXd held = problem.H.topLeftCorner(12, 12).inverse();
  for (int i = 0; i < n; ++i) {
    EXPECT_EQ(inverse.is_free(problem.block_of(i)), i >= 6) << i;
    if (i >= 6) continue;
    const MatrixXd expected = held.block(2 * i, 2 * i, 2, 2);
    EXPECT_LT((inverse.block(problem.block_of(i), problem.block_of(i)) - expected).norm(), 1e-10 * expected.norm()) << i;
  }
}

}  // namespace
}  // namespace holdfast
