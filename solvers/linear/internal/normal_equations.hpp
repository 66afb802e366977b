// The linearised problem at some values: H δ = −g with H = Σ w JᵀWJ in blocks, one block row and column a free variable, lower
// triangle, in a given elimination order. The pattern and every factor's place in it are found once; assembling allocates nothing.
#pragma once

#include <holdfast/graph/resolved.hpp>

namespace holdfast {

/// The lower triangle of a symmetric block-sparse matrix, by block columns; the diagonal block comes first in its column.
struct BlockPattern {
  std::vector<int> dims;          ///< of block i
  std::vector<int> offsets;       ///< first scalar row of block i; one more at the end
  std::vector<int> column_begin;  ///< into rows, by column; one more at the end
  std::vector<int> rows;          ///< block row, ascending in each column
  std::vector<int> block_begin;   ///< first value of each block, column-major dims[row] × dims[column]; one more at the end

  int size() const { return static_cast<int>(dims.size()); }
  int scalar_size() const { return offsets.back(); }
};

class NormalEquations {
 public:
  /// order: the numbers (Resolved::variables) of all free variables, first eliminated first.
  NormalEquations(const Graph& graph, const Resolved& resolved, const std::vector<int>& order);

  /// Fills H and g, returns the cost. The same bits for any number of threads.
  double linearize(const Graph& graph, const Resolved& resolved, const Values& values, Curvature curvature, ThreadPool* pool = nullptr);
  /// The same where the residuals and Jacobians of each batch are known (of linear factors the Jacobians never change).
  double linearize_at(const Graph& graph, const std::vector<std::vector<double>>& r, const std::vector<std::vector<double>>& J,
                      Curvature curvature, ThreadPool* pool = nullptr);

  const BlockPattern& pattern() const { return pattern_; }
  const std::vector<double>& H() const { return H_; }
  const std::vector<double>& gradient() const { return gradient_; }  ///< in elimination order
  const std::vector<int>& order() const { return order_; }
  /// y = H x, both in elimination order.
  void multiply(const std::vector<double>& x, std::vector<double>& y) const;
  /// Between the elimination order and Resolved's tangent.
  void to_tangent(const Resolved& resolved, const double* ordered, double* tangent) const;
  void from_tangent(const Resolved& resolved, const double* tangent, double* ordered) const;

 private:
  // Where a factor's contributions go: for each of its blocks, then for each of its variables' gradients.
  struct Target {
    int begin = -1;  // in H_ or gradient_; −1: a fixed variable
    bool transposed = false;
  };
  struct Plan {
    std::vector<Target> targets;  // targets_per_factor each
    std::vector<int> rows, cols;  // of each target's block, the same for every factor (a gradient is rows × 1)
    std::size_t first_contribution = 0;
  };
  void find_pattern(const Graph& graph, const Resolved& resolved, const std::vector<int>& position);
  void plan_batch(const FactorBatch& factors, const Resolved::Batch& batch, const std::vector<int>& position, Plan& plan) const;
  int block_at(int row, int column) const;
  /// Adds the contributions of factors [first, last) to the part of H and g that lies in the given ranges.
  struct Part {
    int H_begin, H_end, gradient_begin, gradient_end;
  };
  void scatter(const FactorBatch& factors, const Plan& plan, int first, int last, const double* contributions, const Part& part);
  Part part_of(int part, int parts) const;
  /// contribute(batch, first, last, out): FactorBatch::contributions of these factors.
  template <class Contribute>
  double accumulate(const Graph& graph, ThreadPool* pool, const Contribute& contribute);
  template <class Contribute>
  double accumulate_serially(const Graph& graph, const Contribute& contribute);
  template <class Contribute>
  double accumulate_in_parallel(const Graph& graph, ThreadPool& pool, const Contribute& contribute);

  BlockPattern pattern_;
  std::vector<int> order_;
  std::vector<Plan> plans_;
  std::vector<double> H_, gradient_;
  std::vector<double> contributions_;
};

}  // namespace holdfast
