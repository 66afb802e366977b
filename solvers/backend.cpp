#include <algorithm>
#include <holdfast/graph/detail/evaluation_error.hpp>
#include <holdfast/solvers/backend.hpp>
#include <holdfast/solvers/detail/clock.hpp>
#include <holdfast/solvers/second_order.hpp>

namespace holdfast {

Summary Backend::solve(const Graph& graph, Values& values) {
  const Stopwatch watch;
  options.validate();
  if (graph.size() == 0) fail<BadProblem>("the graph has no factors; add measurements before solving");
  for (const auto& batch : graph.batches()) detail::take_error(*batch);  // of evaluations before this solve
  scratch_ = values;
  Summary summary = minimize(graph, scratch_);
  for (const auto& batch : graph.batches())
    if (const std::string error = detail::take_error(*batch); !error.empty()) {
      summary.termination = Termination::failed;
      summary.rule = "a function of the graph threw";
      summary.culprit = batch->name() + ": " + error;
    }
  if (scratch_.structure() != values.structure()) {
    summary.termination = Termination::failed;
    summary.rule = "the back-end added or erased variables";
    summary.culprit = name();
  }
  if (summary.usable()) values.assign(scratch_);
  if (summary.usable() && (options.second_order || options.findings)) look_further(graph, values, summary);
  summary.is_convex = is_convex_problem(graph);
  summary.seconds = watch.seconds();
  return summary;
}

bool is_convex_problem(const Graph& graph) {
  return std::all_of(graph.batches().begin(), graph.batches().end(),
                     [](const auto& batch) { return batch->is_convex() && batch->family().is_convex(); });
}

void Backend::look_further(const Graph& graph, Values& values, Summary& summary) {
  if (options.second_order && !may_hide_saddles(graph)) {
    summary.not_checked = "no factor that could hide a saddle";
  } else if (options.second_order) {
    SecondOrder end = second_order_from(graph, values, *this, summary);
    std::vector<Iteration> trace = std::move(summary.trace);
    if (end.summary.usable()) summary = std::move(end.summary);
    if (!trace.empty()) summary.trace.swap(trace);
    summary.minimum = end.verdict;
    summary.not_checked = end.why;
    summary.saddles_left = end.saddles;
    summary.seconds_second_order = end.seconds_check;
  }
  if (options.findings) summary.findings = check(graph, values);
}

}  // namespace holdfast
