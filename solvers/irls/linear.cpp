#include <algorithm>
#include <cmath>
#include <holdfast/solvers/irls/internal/workspace.hpp>
#include <holdfast/solvers/linear/internal/linear_rows.hpp>

namespace holdfast {
namespace {

constexpr double kSlopeAccuracy = 0.3;  // of the line search: the next Newton step mends the rest
constexpr double kStalled = 1e-14;      // relative decrease of the cost that is rounding

}  // namespace

void Irls::Workspace::evaluate_linear(const Graph& graph) {
  const std::size_t batches = graph.batches().size();
  for (auto* arrays : {&r, &J, &Jd, &row_weights}) arrays->resize(batches);
  for (std::size_t b = 0; b < batches; ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    const std::size_t rows = static_cast<std::size_t>(batch.size()) * batch.residual_dim();
    r[b].resize(rows);
    Jd[b].resize(rows);
    row_weights[b].resize(rows);
    weights_of_rows(batch, row_weights[b].data());
    J[b].resize(rows * batch.total_dim());
    batch.evaluate(best, resolved.batches()[b].index.data(), 0, batch.size(), r[b].data(), J[b].data());
  }
}

void Irls::Workspace::apply_step(const Graph& graph) {
  normal.to_tangent(resolved, step.data(), tangent.data());
  for (std::size_t b = 0; b < r.size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    batch.apply_jacobians(J[b].data(), offsets[b].data(), 0, batch.size(), tangent.data(), Jd[b].data());
  }
}

void Irls::Workspace::move_along(double alpha) {
  for (std::size_t b = 0; b < r.size(); ++b)
    for (std::size_t k = 0; k < r[b].size(); ++k) r[b][k] += alpha * Jd[b][k];
  for (std::size_t k = 0; k < tangent.size(); ++k) total[k] += alpha * tangent[k];
}

/// A linear problem too wide for LinearRows: blocks in fronts.
struct Irls::Fronts {
  Workspace& w;
  ThreadPool& pool;

  const Resolved& resolved() const { return w.resolved; }
  double linearize(const Graph& graph, Curvature curvature) { return w.normal.linearize_at(graph, w.r, w.J, curvature, &pool); }
  const std::vector<double>& gradient() const { return w.normal.gradient(); }
  double solve_damped(double lambda) {
    w.read_diagonal();
    return w.solve_damped(lambda);
  }
  void apply_step(const Graph& graph) { w.apply_step(graph); }
  Phi phi(const Graph& graph, double alpha) const {
    Phi sum;
    for (std::size_t b = 0; b < w.r.size(); ++b)
      sum += phi_of_batch(*graph.batches()[b], w.row_weights[b].data(), w.r[b].data(), w.Jd[b].data(), alpha);
    return sum;
  }
  double slope() const { return dot(w.normal.gradient(), w.step); }
  void move_along(double alpha) { w.move_along(alpha); }
};

// r and J at the start once; from then on everything happens in the tangent space: x = x⁰ ⊕ total, r = r⁰ + J total.
template <class Model>
void Irls::descend(const Graph& graph, const Values& start, Model& model, Progress& progress) {
  Summary& summary = progress.summary;
  const Curvature kind = curvature(graph, true);
  const double first = model.linearize(graph, kind);
  progress.watch.lap(summary.seconds_linearize);
  if (!progress.begin(first, graph, model.resolved(), start)) return;
  double gradient_norm = max_norm(model.gradient());
  double lambda = 0;
  while (!progress.gradient_is_flat(gradient_norm) && progress.go_on(gradient_norm)) {
    ++summary.iterations;
    const double predicted = model.solve_damped(lambda);
    progress.watch.lap(summary.seconds_solve);
    if (!std::isfinite(predicted)) {  // some direction is free: the least bit of damping makes the matrix definite
      lambda = lambda == 0 ? 1e-9 : 10 * lambda;
      if (lambda < 1e9) continue;
      progress.end(Termination::failed, "the normal equations are not positive definite under any damping");
      return;
    }
    model.apply_step(graph);
    const Phi here{summary.cost, model.slope(), 0};
    model.move_along(minimize_along(here, kSlopeAccuracy, [&](double alpha) { return model.phi(graph, alpha); }));
    const double before = summary.cost;
    summary.cost = std::min(before, model.linearize(graph, kind));
    progress.watch.lap(summary.seconds_linearize);
    gradient_norm = max_norm(model.gradient());
    // A step cut short by the line search lowers the cost little, however far the minimum is: the model must say so, too.
    if (predicted <= options.cost_tolerance * before || before - summary.cost <= kStalled * before) {
      progress.end(Termination::converged, "the relative decrease of the cost is within cost_tolerance");
      break;
    }
  }
  summary.gradient_norm = gradient_norm;
}

void Irls::minimize_rows(const Graph& graph, Values& values, Progress& progress) {
  descend(graph, values, *rows_, progress);
  if (progress.summary.usable()) rows_->retract(values);
}

void Irls::minimize_linear(const Graph& graph, Progress& progress) {
  Workspace& w = *workspace_;
  w.evaluate_linear(graph);
  w.total.assign(w.tangent.size(), 0.0);
  Fronts fronts{w, w.pool};
  descend(graph, w.best, fronts, progress);
  w.resolved.retract(w.best, w.total.data(), w.candidate);
  std::swap(w.best, w.candidate);
}

}  // namespace holdfast
