#include <cmath>
#include <holdfast/graph/gradient.hpp>
#include <holdfast/solvers/internal/minimizer.hpp>
#include <holdfast/solvers/nesterov/internal/chain_preconditioner.hpp>
#include <holdfast/solvers/nesterov/nesterov.hpp>

namespace holdfast {
namespace {

constexpr int kMaxIterations = 10000;
constexpr double kRounding = 1e-14;      // of the cost: what a comparison of two costs can tell
constexpr double kMostLipschitz = 1e30;  // in the metric P, where 2 bounds any graph of pairwise linear factors
constexpr double kSteep = 8;             // an L above this says that P misses curvature
constexpr int kPatience = 50;            // iterations over which a slow decrease is measured

}  // namespace

struct Nesterov::Workspace {
  Resolved resolved;
  GradientEvaluator evaluate;
  ChainPreconditioner preconditioner;
  ThreadPool pool;
  Values x, y, next;
  std::vector<double> gradient, direction, step, move;
  double t = 1, L = 1;
  bool plain = true;  ///< y = x: a step without momentum

  Workspace(const Graph& graph, const Values& values, int threads)
      : resolved(graph, values), evaluate(graph), preconditioner(graph, resolved), pool(threads), x(values), y(values), next(values) {
    for (std::vector<double>* v : {&gradient, &direction, &step, &move}) v->resize(resolved.tangent_dim());
  }

  /// next = y ⊕ −(1/L) direction, L raised until f(next) ≤ f(y) − ‖g‖²/2L; returns f(next), or NaN where no L does.
  double backtrack(const Graph& graph, double cost_y, double norm2) {
    for (; L < kMostLipschitz; L *= 2) {
      for (std::size_t i = 0; i < step.size(); ++i) step[i] = -direction[i] / L;
      resolved.retract(y, step.data(), next);
      const double cost = resolved.cost(graph, next, &pool);
      if (cost <= cost_y - norm2 / (2 * L) + kRounding * std::abs(cost_y)) return cost;
    }
    return NAN;
  }

  /// y = next ⊕ β (next ⊖ x), x = next; returns gᵀ(next ⊖ x): positive where the momentum points uphill.
  double extrapolate(double beta) {
    resolved.local(x, next, move.data());
    double uphill = 0;
    for (std::size_t i = 0; i < move.size(); ++i) {
      uphill += gradient[i] * move[i];
      move[i] *= beta;
    }
    std::swap(x, next);
    resolved.retract(x, move.data(), y);
    return uphill;
  }

  /// Once more from x, without momentum.
  void restart() {
    y.assign(x);
    t = L = 1;
    plain = true;
  }

  /// x = next, and y ahead of it by Nesterov's t; no momentum that points uphill, none in a metric that has just changed.
  void accept() {
    const double t_next = (1 + std::sqrt(1 + 4 * t * t)) / 2;
    const bool uphill = extrapolate((t - 1) / t_next) > 0;
    plain = t == 1 || uphill;
    if (uphill) y.assign(x);
    t = uphill ? 1 : t_next;
    if (L > kSteep && preconditioner.round_off()) restart();
    L *= 0.98;  // what the last bound no longer needs
  }
};

Nesterov::Nesterov(Options chosen) : Backend(std::move(chosen)) {}
Nesterov::~Nesterov() = default;

Summary Nesterov::minimize(const Graph& graph, Values& values) {
  Progress progress(options, kMaxIterations);
  Summary& summary = progress.summary;
  workspace_ = std::make_unique<Workspace>(graph, values, options.threads);
  Workspace& w = *workspace_;
  if (w.resolved.tangent_dim() == 0) fail<BadProblem>("every variable that a factor touches is fixed; there is nothing to solve for");
  if (!progress.begin(w.resolved.cost(graph, values, &w.pool), graph, w.resolved, values)) return summary;
  w.preconditioner.update(graph, w.resolved, w.x, &w.pool);
  progress.watch.lap(summary.seconds_setup);

  w.evaluate(graph, w.resolved, w.x, w.gradient, &w.pool);
  double gradient_norm = max_norm(w.gradient), patience_cost = summary.cost;
  while (progress.go_on(gradient_norm)) {
    const double cost_y = w.evaluate(graph, w.resolved, w.y, w.gradient, &w.pool);
    gradient_norm = max_norm(w.gradient);
    if (w.plain && progress.gradient_is_flat(gradient_norm)) break;
    const double norm2 = w.preconditioner.apply(w.resolved, w.gradient, w.direction);
    ++summary.iterations;
    const double cost = std::isfinite(cost_y) && std::isfinite(norm2) ? w.backtrack(graph, cost_y, norm2) : NAN;
    if (!(cost < summary.cost)) {  // momentum went too far: once more from x, without it
      if (w.plain) {
        progress.end(Termination::converged, "no step, however short, lowers the cost");
        break;
      }
      w.preconditioner.update(graph, w.resolved, w.x, &w.pool);
      if (w.L > kSteep) w.preconditioner.round_off();
      w.restart();
      continue;
    }
    w.accept();
    summary.cost = cost;
    if (summary.iterations % kPatience == 0) {
      if (norm2 / 2 <= options.cost_tolerance * summary.cost && progress.decrease_is_small(patience_cost, summary.cost)) break;
      patience_cost = summary.cost;
    }
  }
  w.evaluate(graph, w.resolved, w.x, w.gradient, &w.pool);
  summary.gradient_norm = max_norm(w.gradient);
  values.assign(w.x);
  return summary;
}

}  // namespace holdfast
