// Sparse Cholesky of the (damped) normal equations. The symbolic phase runs once per structure.
#pragma once

#include <holdfast/graph/normal_equations.hpp>
#include <memory>

namespace holdfast {

/// An elimination order of the free variables with little fill-in.
std::vector<int> elimination_order(const Graph& graph, const Resolved& resolved);

class BlockCholesky {
 public:
  explicit BlockCholesky(const BlockPattern& pattern);
  ~BlockCholesky();
  BlockCholesky(BlockCholesky&&) noexcept;
  BlockCholesky& operator=(BlockCholesky&&) noexcept;

  /// Factors H + diag(damping); false where that is not positive definite to working precision.
  bool factor(const std::vector<double>& H, const std::vector<double>& damping);
  /// Solves (H + diag(damping)) x = b; in elimination order.
  void solve(const std::vector<double>& b, std::vector<double>& x) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace holdfast
