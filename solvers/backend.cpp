#include <holdfast/solvers/backend.hpp>
#include <holdfast/solvers/detail/clock.hpp>

namespace holdfast {

Summary Backend::solve(const Graph& graph, Values& values) {
  const Stopwatch watch;
  options.validate();
  if (graph.size() == 0) fail<BadProblem>("the graph has no factors; add measurements before solving");
  scratch_ = values;
  Summary summary = minimize(graph, scratch_);
  if (scratch_.structure() != values.structure()) {
    summary.termination = Termination::failed;
    summary.rule = "the back-end added or erased variables";
    summary.culprit = name();
  }
  if (summary.usable()) values.assign(scratch_);
  summary.seconds = watch.seconds();
  return summary;
}

}  // namespace holdfast
