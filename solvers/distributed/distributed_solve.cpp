#include <cmath>
#include <holdfast/graph/detail/evaluation_error.hpp>
#include <holdfast/solvers/distributed/internal/distributed_solve.hpp>

namespace holdfast::detail {

Summary solve_together(DistributedGraph& graph, const Options& options, bool ghosts_are_constants,
                       const std::function<Summary(DistributedProblem&)>& minimize) {
  const Stopwatch watch;
  const Communicator& all = graph.communicator();
  all.agree([&] {
    options.validate();
    if ((options.second_order || options.findings) && all.size() > 1)
      fail<BadOption>("second_order and findings look at the whole graph, which no process has here; ask for them in one process");
  });
  DistributedProblem problem(graph, ghosts_are_constants);
  const Values start = graph.values();
  problem.update(graph.values());
  Summary summary;
  std::string error;  // of a factor's function: all processes end together before one says so
  try {
    summary = minimize(problem);
  } catch (...) {
    graph.values().assign(start);
    throw;
  }
  for (const auto& batch : graph.graph().batches())
    if (const std::string text = detail::take_error(*batch); !text.empty()) error = batch->name() + ": " + text;
  if (all.any(!error.empty())) {
    summary.termination = Termination::failed;
    summary.rule = "a function of the graph threw";
    summary.culprit = error;
  }
  if (all.any(!summary.usable())) {
    summary.termination = Termination::failed;
    graph.values().assign(start);
  }
  summary.is_convex = !all.any(!is_convex_problem(graph.graph()));
  summary.seconds = watch.seconds();
  return summary;
}

void watch_together(const DistributedProblem& problem, const Options& options, Progress& progress) {
  const Communicator& all = problem.communicator();
  if (all.size() > 1 && all.any(options.progress || std::isfinite(options.time_limit)))
    progress.largest_of_all = [&all](double x) { return all.max(x); };
}

}  // namespace holdfast::detail
