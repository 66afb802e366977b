// The back-end "petsc": the Newton and Gauss–Newton steps of irls with PETSc's parallel linear algebra, in any number of processes.
//
//   Petsc solver;
//   solver.petsc_options.text = "-ksp_type cg -pc_type gamg";     // or in the environment: PETSC_OPTIONS
//   Summary s = solver.solve(distributed_graph);                  // collective; on one process also solve(graph, values)
//
// Convex graphs by a semismooth Newton method with the factors' own Hessians, damped, with a line search; all others by Gauss–Newton with
// IRLS weights and dogleg steps within a trust region: the same rules as irls (solvers/irls/irls.hpp) without its geodesic acceleration and
// its chordal restart. H is a MATAIJ with the block size of the variables where all have the same. Each process computes the rows of
// its own variables whole, so nothing is sent to assemble it.
//
// Linear solver. Whatever PETSc's options say; where they say nothing:
//   up to OfPetsc::direct_limit scalars   MUMPS' Cholesky factorisation
//   more                                  conjugate gradients with overlapping Schwarz (ASM, overlap 1, symmetric), a Cholesky
//                                         factorisation a process: no coarse level, so more processes need more iterations
// With -pc_type gamg the rigid motions of the positions are its near-nullspace: a range network is a truss of elastic bars.
// An iterative solver is asked for a relative residual of `tolerance`, of a matrix that is damped by 1e-8 of its diagonal at least; what
// makes it fail is damped more.
#pragma once

#include <holdfast/solvers/backend.hpp>
#include <holdfast/solvers/distributed/distributed_graph.hpp>

namespace holdfast {

namespace detail {
class DistributedProblem;
}

/// What only this back-end has.
struct OfPetsc {
  std::string text;                    ///< PETSc's own options, as on a command line: every one reaches it
  std::int64_t direct_limit = 200000;  ///< scalars of all processes
  double tolerance = 1e-8;             ///< 0 < tolerance < 1: of iterative solvers
};

/// What the linear solver did in the last solve.
struct PetscReport {
  std::string solver;           ///< "preonly + cholesky (mumps)", "cg + gamg"
  std::vector<int> iterations;  ///< of each linear system
  std::int64_t scalars = 0;     ///< of all processes
  int block_size = 1;
};

class Petsc final : public Backend {
 public:
  explicit Petsc(Options chosen = {}, OfPetsc of_petsc = {});
  std::string name() const override { return "petsc"; }

  using Backend::solve;
  /// Collective: all processes with the same options (a progress callback and a time limit may be in one alone; all stop with it). The
  /// answer is in graph.values(), ghosts too; after a failure the start is. The Summary is the same in all, but for seconds and culprit.
  /// second_order and findings are for one process: BadOption where there are more. Throws BadOption, BadProblem.
  Summary solve(DistributedGraph& graph);

  OfPetsc petsc_options;
  const PetscReport& report() const { return report_; }

 protected:
  Summary minimize(const Graph& graph, Values& values) override;

 private:
  Summary descend(detail::DistributedProblem& problem);

  PetscReport report_;
};

}  // namespace holdfast
