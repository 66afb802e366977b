// Sparse Cholesky of the (damped) normal equations: multifrontal, on the block graph, with dense fronts in one arena.
//
// Symbolic phase once per structure; after it neither factor nor solve allocates. The same bits for any number of threads:
// each front is computed by the same operations in the same order whichever thread takes it.
#pragma once

#include <holdfast/solvers/linear/internal/normal_equations.hpp>
#include <holdfast/solvers/linear/internal/symbolic.hpp>

namespace holdfast {

class BlockCholesky {
 public:
  /// pattern: of H in symbolic.order.
  BlockCholesky(Symbolic symbolic, const BlockPattern& pattern);

  /// Factors H + diag(damping); false where that is not positive definite to working precision.
  bool factor(const std::vector<double>& H, const std::vector<double>& damping, ThreadPool* pool = nullptr);
  /// Solves (H + diag(damping)) x = b, in elimination order.
  void solve(const std::vector<double>& b, std::vector<double>& x);

  double flops() const { return symbolic_.flops; }
  std::size_t factor_size() const { return panels_.size(); }  ///< doubles

 private:
  struct Run {  // consecutive rows of a child's update that are consecutive rows of its parent's front
    int from, to, length;
  };
  struct Front {
    int k, n, ld;        // panel: n × k
    int m, update_ld;    // update: m × m, lower
    std::size_t panel;   // in panels_
    std::size_t update;  // in arena_
    int first_scalar;    // of the own columns
    int parent;
    std::vector<int> children;
    std::vector<Run> runs;                      // of its update in the parent's front
    std::vector<std::pair<int, int>> row_runs;  // (first scalar row, length) of the rows below
    std::vector<int> block_places;              // of each H block of the own columns, in the panel
    int first_block;                            // of those in H's pattern
  };

  void make_fronts(const BlockPattern& pattern);
  void make_tasks();
  void plan_arena();
  bool eliminate(Front& front, const double* H, const double* damping, ThreadPool* pool);
  void assemble(Front& front, const double* H, const double* damping);
  void extend_add(const Front& child, Front& front, bool own);

  Symbolic symbolic_;
  BlockPattern pattern_;
  std::vector<Front> fronts_;
  std::vector<std::vector<int>> tasks_;  // disjoint subtrees, each a list of fronts in postorder
  std::vector<int> top_;                 // the fronts above them
  std::vector<double> panels_, arena_, work_;
};

}  // namespace holdfast
