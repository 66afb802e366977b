#include <algorithm>
#include <holdfast/solvers/distributed/backends.hpp>
#include <holdfast/solvers/distributed/internal/distributed_solve.hpp>
#include <holdfast/solvers/distributed/internal/dogleg_descent.hpp>
#include <holdfast/solvers/distributed/internal/petsc_system.hpp>
#include <holdfast/solvers/distributed/nesterov_mpi.hpp>
#include <holdfast/solvers/irls/internal/convex_descent.hpp>
#include <holdfast/solvers/table.hpp>

namespace holdfast {
namespace {

constexpr int kMaxIterations = 1000;

void validate(const OfPetsc& options) {
  if (!(options.tolerance > 0 && options.tolerance < 1)) fail<BadOption>("tolerance = ", options.tolerance, " must be within (0, 1)");
  if (options.direct_limit < 0) fail<BadOption>("direct_limit = ", options.direct_limit, " must be >= 0");
}

}  // namespace

Petsc::Petsc(Options chosen, OfPetsc of_petsc) : Backend(std::move(chosen)), petsc_options(std::move(of_petsc)) {}

Summary Petsc::solve(DistributedGraph& graph) {
  return detail::solve_together(graph, options, false, [this](detail::DistributedProblem& problem) { return descend(problem); });
}

Summary Petsc::minimize(const Graph& graph, Values& values) {
  detail::DistributedProblem problem(graph, values);
  return descend(problem);
}

Summary Petsc::descend(detail::DistributedProblem& problem) {
  validate(petsc_options);
  Progress progress(options, kMaxIterations);
  detail::watch_together(problem, options, progress);
  detail::PetscSystem system(problem, petsc_options, options.threads, report_);
  progress.watch.lap(progress.summary.seconds_setup);
  if (!problem.communicator().any(!is_convex_problem(problem.graph()))) {
    detail::ConvexDescent descent(problem.values());
    descent.minimize(problem.graph(), system, problem.values(), progress);
  } else {
    detail::descend_by_dogleg(problem.graph(), system, problem.values(), progress);
  }
  return std::move(progress.summary);
}

void register_mpi_backends() {
  register_backend("petsc", [](const Options& options) { return std::make_unique<Petsc>(options); });
  register_backend("nesterov-mpi", [](const Options& options) { return std::make_unique<NesterovMpi>(options); });
}

}  // namespace holdfast
