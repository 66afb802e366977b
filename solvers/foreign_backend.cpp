#include <holdfast/graph/gradient.hpp>
#include <holdfast/solvers/internal/foreign_backend.hpp>

namespace holdfast {

Summary ForeignBackend::minimize(const Graph& graph, Values& values) {
  constexpr double rounding = 1e-12;  // what a converged optimizer may add to the cost, relatively
  Progress progress(options, kMaxIterations);
  Summary& summary = progress.summary;
  const Resolved resolved(graph, values);
  if (resolved.tangent_dim() == 0) fail<BadProblem>("every variable that a factor touches is fixed; there is nothing to solve for");
  if (!progress.begin(resolved.cost(graph, values), graph, resolved, values)) return summary;

  optimize(graph, resolved, values, progress);
  summary.cost = summary.usable() ? resolved.cost(graph, values) : summary.cost_first;
  if (!(summary.cost <= (1 + rounding) * summary.cost_first)) {
    progress.end(Termination::failed, "the optimizer ended above its start");
    summary.cost = summary.cost_first;
  }
  if (!summary.usable()) return summary;
  std::vector<double> gradient;
  GradientEvaluator evaluate(graph);
  evaluate(graph, resolved, values, gradient);
  summary.gradient_norm = max_norm(gradient);
  return summary;
}

}  // namespace holdfast
