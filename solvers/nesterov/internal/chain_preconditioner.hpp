// The preconditioner of the first-order back-end: per agent, the block-tridiagonal part of H along its own chain of variables.
//
//   P = H restricted to the diagonal blocks and to the blocks between consecutive variables of one agent, with every loss at its
//       steepest (w ρ'(0) JᵀJ: an upper bound for any weights to come).
// It is positive semi-definite, since a factor's diagonal blocks alone are; for pairwise factors H ≼ 2P. Each agent factors and
// solves its own chain: nothing is exchanged.
#pragma once

#include <holdfast/solvers/linear/internal/block_cholesky.hpp>

namespace holdfast {

class ChainPreconditioner {
 public:
  /// all: P is the whole of H, which has to be factored by one process, and bounds it (H ≼ P).
  enum class Kept { chains, all };

  ChainPreconditioner(const Graph& graph, const Resolved& resolved, Kept kept = Kept::chains);

  /// Takes H at these values; a variable that was stiffer before (larger trace) keeps that much.
  void update(const Graph& graph, const Resolved& resolved, const Values& values, ThreadPool* pool);
  /// Adds more of the identity to every block: for factors that curve more than their JᵀJ says (ranges bend sideways).
  /// False where P is as round as it can be.
  bool round_off();
  /// out = P⁻¹ g in Resolved's tangent; returns gᵀ P⁻¹ g.
  double apply(const Resolved& resolved, const std::vector<double>& g, std::vector<double>& out);

 private:
  struct Ordered;
  static Ordered order_of(const Graph& graph, const Resolved& resolved, Kept kept);
  ChainPreconditioner(const Graph& graph, const Resolved& resolved, Ordered ordered);
  void factor();

  NormalEquations normal_;  // all of H, in the order of the chains
  BlockPattern chains_;     // the part that is kept
  std::vector<int> kept_;   // of each kept value: where it is in H
  std::unique_ptr<BlockCholesky> cholesky_;
  std::vector<double> values_;    // of the kept blocks
  std::vector<double> traces_;    // of each diagonal block now
  std::vector<double> stiffest_;  // the largest so far
  std::vector<double> added_, ordered_, solved_;
  double roundness_ = 1e-9;  // of the stiffest trace
};

}  // namespace holdfast
