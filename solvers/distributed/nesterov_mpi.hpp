// The back-end "nesterov-mpi": nesterov (solvers/nesterov/nesterov.hpp) in any number of processes. Each moves its own variables by its own
// part of the gradient in the metric of its own chains (the block-tridiagonal part of H along each agent's variables that it owns), with
// Nesterov's momentum and restart. Neighbours send each other their boundary states twice an iteration, once for each step length that is
// tried and once for the extrapolated point; all that is global is a handful of scalars: costs, norms, the angle of momentum and gradient.
//
//   NesterovMpi().solve(distributed_graph);      // collective
//
// For pairwise factors H ≼ 2P whichever process owns what, since a factor's own blocks bound it; so more processes need no more iterations
// but for the chains that are cut.
#pragma once

#include <holdfast/solvers/backend.hpp>
#include <holdfast/solvers/distributed/distributed_graph.hpp>

namespace holdfast {

namespace detail {
class DistributedProblem;
}

class NesterovMpi final : public Backend {
 public:
  explicit NesterovMpi(Options chosen = {}) : Backend(std::move(chosen)) {}
  std::string name() const override { return "nesterov-mpi"; }

  using Backend::solve;
  /// As Petsc::solve.
  Summary solve(DistributedGraph& graph);

 protected:
  Summary minimize(const Graph& graph, Values& values) override;

 private:
  Summary descend(detail::DistributedProblem& problem);
};

}  // namespace holdfast
