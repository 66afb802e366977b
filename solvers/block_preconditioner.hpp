// Block-diagonal preconditioner: one dense Cholesky factor a variable.
#pragma once

#include <holdfast/graph/normal_equations.hpp>

namespace holdfast {

class BlockPreconditioner {
 public:
  BlockPreconditioner(const Graph& graph, const Resolved& resolved);

  /// Takes the diagonal blocks of H at these values wherever they are stiffer (larger trace) than those it has.
  void update(const Graph& graph, const Resolved& resolved, const Values& values, ThreadPool* pool);
  /// out = P⁻¹ g in Resolved's tangent; returns gᵀ P⁻¹ g.
  double apply(const std::vector<double>& g, std::vector<double>& out) const;

 private:
  void factor(int block, double floor);

  NormalEquations normal_;
  std::vector<int> offsets_;          // of each block's variable in the tangent
  std::vector<std::size_t> begin_;    // of each block's factor
  std::vector<double> factors_;       // lower Cholesky factors, column-major
  std::vector<double> traces_;
};

}  // namespace holdfast
