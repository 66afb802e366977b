// A symmetric matrix of B × B blocks, one block row a node, in the pattern of pairs of nodes, and its Cholesky factorisation. Internal.
#pragma once

#include <algorithm>
#include <holdfast/graph/math.hpp>
#include <holdfast/solvers/linear/internal/block_cholesky.hpp>

namespace holdfast::detail {

/// Pairs of nodes, no node with itself; the same pair may occur again.
inline BlockGraph block_graph_of(int size, int dim, std::vector<std::pair<int, int>> pairs) {
  const std::size_t count = pairs.size();
  for (std::size_t i = 0; i < count; ++i) pairs.emplace_back(pairs[i].second, pairs[i].first);
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  BlockGraph graph;
  graph.dims.assign(size, dim);
  graph.begin.assign(size + 1, 0);
  for (const auto& [from, to] : pairs) {
    ++graph.begin[from + 1];
    graph.neighbours.push_back(to);
  }
  for (int i = 0; i < size; ++i) graph.begin[i + 1] += graph.begin[i];
  return graph;
}

template <int B>
class TiedBlocks {
 public:
  using Block = Matrix<B, B>;
  using Vectors = Eigen::MatrixXd;  ///< B rows a node, in the order of the nodes

  explicit TiedBlocks(const BlockGraph& graph) : TiedBlocks(graph, analyze(graph)) {}

  int rows() const { return pattern_.scalar_size(); }
  void set_zero() { std::fill(values_.begin(), values_.end(), 0.0); }

  /// Adds to block (i, j); of i ≠ j one of the two is given.
  void add(int i, int j, const Block& block) {
    const int row = position_[i], column = position_[j];
    if (row >= column)
      at(row, column) += block;
    else
      at(column, row) += block.transpose();
  }

  /// Calls fn(i, j, block) for every stored block: either (i, j) or (j, i) of i ≠ j, and (i, i).
  template <class Fn>
  void for_each(Fn&& fn) const {
    for (int c = 0; c < pattern_.size(); ++c)
      for (int k = pattern_.column_begin[c]; k < pattern_.column_begin[c + 1]; ++k)
        fn(order_[pattern_.rows[k]], order_[c], Block(Eigen::Map<const Block>(&values_[pattern_.block_begin[k]])));
  }

  /// Factors this + diag(shift), shift[k] for row k of every node; false where that is not positive definite by a margin of some
  /// roundings of its diagonal: a matrix that is accepted is one.
  bool factor(const Vector<B>& shift) {
    constexpr double kMargin = 16 * std::numeric_limits<double>::epsilon();
    damping_.resize(rows());
    for (int c = 0; c < pattern_.size(); ++c) {
      const Block diagonal = Eigen::Map<const Block>(&values_[pattern_.block_begin[pattern_.column_begin[c]]]);
      for (int k = 0; k < B; ++k) damping_[pattern_.offsets[c] + k] = shift[k] - kMargin * std::abs(diagonal(k, k));
    }
    return cholesky_.factor(values_, damping_);
  }

  Vectors solve(const Vectors& b) {
    std::vector<double> rhs(rows()), x(rows());
    Vectors solution(b.rows(), b.cols());
    for (Eigen::Index column = 0; column < b.cols(); ++column) {
      for (std::size_t p = 0; p < order_.size(); ++p)
        for (int k = 0; k < B; ++k) rhs[p * B + k] = b(order_[p] * B + k, column);
      cholesky_.solve(rhs, x);
      for (std::size_t p = 0; p < order_.size(); ++p)
        for (int k = 0; k < B; ++k) solution(order_[p] * B + k, column) = x[p * B + k];
    }
    return solution;
  }

 private:
  TiedBlocks(const BlockGraph& graph, Symbolic symbolic)
      : order_(symbolic.order),
        position_(order_.size()),
        pattern_(pattern_of(graph, symbolic.order, position_)),
        values_(pattern_.block_begin.back(), 0.0),
        cholesky_(std::move(symbolic), pattern_) {}

  static BlockPattern pattern_of(const BlockGraph& graph, const std::vector<int>& order, std::vector<int>& position) {
    const int size = graph.size();
    for (int p = 0; p < size; ++p) position[order[p]] = p;
    BlockPattern pattern;
    pattern.dims.assign(size, B);
    for (int p = 0; p <= size; ++p) pattern.offsets.push_back(p * B);
    pattern.column_begin.push_back(0);
    for (int p = 0; p < size; ++p) {
      std::vector<int> below{p};
      for (int k = graph.begin[order[p]]; k < graph.begin[order[p] + 1]; ++k)
        if (position[graph.neighbours[k]] > p) below.push_back(position[graph.neighbours[k]]);
      std::sort(below.begin(), below.end());
      pattern.rows.insert(pattern.rows.end(), below.begin(), below.end());
      pattern.column_begin.push_back(static_cast<int>(pattern.rows.size()));
    }
    for (std::size_t k = 0; k <= pattern.rows.size(); ++k) pattern.block_begin.push_back(static_cast<int>(k) * B * B);
    return pattern;
  }

  Eigen::Map<Block> at(int row, int column) {
    const auto begin = pattern_.rows.begin() + pattern_.column_begin[column];
    const auto end = pattern_.rows.begin() + pattern_.column_begin[column + 1];
    return Eigen::Map<Block>(&values_[pattern_.block_begin[std::lower_bound(begin, end, row) - pattern_.rows.begin()]]);
  }

  std::vector<int> order_, position_;
  BlockPattern pattern_;
  std::vector<double> values_, damping_;
  BlockCholesky cholesky_;
};

}  // namespace holdfast::detail
