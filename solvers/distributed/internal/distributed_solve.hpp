// What Backend::solve does for one process, for many: values unchanged on failure, one end for all. Internal.
#pragma once

#include <holdfast/solvers/distributed/internal/distributed_problem.hpp>
#include <holdfast/solvers/internal/minimizer.hpp>

namespace holdfast::detail {

Summary solve_together(DistributedGraph& graph, const Options& options, bool ghosts_are_constants,
                       const std::function<Summary(DistributedProblem&)>& minimize);

/// Where any process has a time limit or a callback, all end with the first that does.
void watch_together(const DistributedProblem& problem, const Options& options, Progress& progress);

}  // namespace holdfast::detail
