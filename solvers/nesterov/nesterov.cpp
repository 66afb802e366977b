#include <cmath>
#include <holdfast/graph/gradient.hpp>
#include <holdfast/solvers/internal/minimizer.hpp>
#include <holdfast/solvers/nesterov/internal/chain_preconditioner.hpp>
#include <holdfast/solvers/nesterov/internal/flat_descent.hpp>
#include <holdfast/solvers/nesterov/internal/iterates.hpp>
#include <holdfast/solvers/nesterov/nesterov.hpp>

namespace holdfast {
namespace {

constexpr int kMaxIterations = 10000;
constexpr double kSteep = 8;   // an L above this says that P misses curvature
constexpr int kPatience = 50;  // iterations over which a slow decrease is measured

}  // namespace

struct Nesterov::Workspace {
  Resolved resolved;
  GradientEvaluator evaluate;
  ChainPreconditioner preconditioner;
  ThreadPool pool;
  detail::Iterates iterates;
  std::vector<double> gradient, direction;

  Workspace(const Graph& graph, const Values& values, int threads)
      : resolved(graph, values), evaluate(graph), preconditioner(graph, resolved), pool(threads), iterates(resolved, values) {}

  double gradient_at(const Graph& graph, const Values& at) { return evaluate(graph, resolved, at, gradient, &pool); }

  /// f at the next point, which lowers f(y) as much as L says it must; NaN where none does.
  double step(const Graph& graph, double cost_y, double& norm2) {
    norm2 = preconditioner.apply(resolved, gradient, direction);
    if (!std::isfinite(cost_y) || !std::isfinite(norm2)) return NAN;
    return iterates.backtrack(graph, resolved, cost_y, direction, norm2, &pool);
  }
  /// Momentum went too far: once more from x, without it, in a metric of the losses' weights there.
  void begin_again(const Graph& graph) {
    preconditioner.update(graph, resolved, iterates.x(), &pool);
    if (iterates.L() > kSteep) preconditioner.round_off();
    iterates.restart();
  }
  /// No momentum in a metric that has just changed.
  void accept() {
    iterates.accept(resolved, gradient);
    if (iterates.L() > kSteep && preconditioner.round_off()) iterates.restart();
    iterates.lower_L();
  }
};

Nesterov::Nesterov(Options chosen, NesterovOptions of_nesterov) : Backend(std::move(chosen)), nesterov_options(of_nesterov) {}
Nesterov::~Nesterov() = default;

Summary Nesterov::minimize(const Graph& graph, Values& values) {
  Progress progress(options, kMaxIterations);
  Summary& summary = progress.summary;
  if (detail::FlatDescent::serves(graph, values)) {
    const bool whole = nesterov_options.metric == NesterovOptions::Metric::whole;
    detail::FlatDescent(graph, values, whole ? ChainPreconditioner::Kept::all : ChainPreconditioner::Kept::chains, options.threads)
        .minimize(values, progress);
    return summary;
  }
  workspace_ = std::make_unique<Workspace>(graph, values, options.threads);
  Workspace& w = *workspace_;
  if (w.resolved.tangent_dim() == 0) fail<BadProblem>("every variable that a factor touches is fixed; there is nothing to solve for");
  if (!progress.begin(w.resolved.cost(graph, values, &w.pool), graph, w.resolved, values)) return summary;
  w.preconditioner.update(graph, w.resolved, values, &w.pool);
  progress.watch.lap(summary.seconds_setup);

  w.gradient_at(graph, values);
  double gradient_norm = max_norm(w.gradient), patience_cost = summary.cost, norm2 = 0;
  while (progress.go_on(gradient_norm)) {
    const double cost_y = w.gradient_at(graph, w.iterates.y());
    gradient_norm = max_norm(w.gradient);
    if (w.iterates.plain() && progress.gradient_is_flat(gradient_norm)) break;
    ++summary.iterations;
    const double cost = w.step(graph, cost_y, norm2);
    if (!(cost < summary.cost)) {
      if (w.iterates.plain()) {
        progress.end(Termination::converged, "no step, however short, lowers the cost");
        break;
      }
      w.begin_again(graph);
      continue;
    }
    w.accept();
    summary.cost = cost;
    if (summary.iterations % kPatience == 0) {
      if (norm2 / 2 <= options.cost_tolerance * summary.cost && progress.decrease_is_small(patience_cost, summary.cost)) break;
      patience_cost = summary.cost;
    }
  }
  values.assign(w.iterates.x());
  w.gradient_at(graph, values);
  summary.gradient_norm = max_norm(w.gradient);
  return summary;
}

}  // namespace holdfast
