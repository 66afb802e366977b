#include <algorithm>
#include <cmath>
#include <holdfast/solvers/irls_workspace.hpp>
#include <holdfast/solvers/line_search.hpp>

namespace holdfast {
namespace {

constexpr double kSlopeAccuracy = 1e-2;  // of the line search: the next Newton step mends the rest

template <class RhoOfComponent>
Phi sum_components(int rows, int rows_per_factor, const double* weights, const double* r, const double* Jd, double alpha, const RhoOfComponent& rho_of) {
  Phi phi;
  for (int row = 0; row < rows; row += rows_per_factor) {
    Phi factor;
    for (int c = row; c < row + rows_per_factor; ++c) {
      const double x = r[c] + alpha * Jd[c], d = Jd[c];
      const Rho rho = rho_of(x);
      factor.value += 0.5 * rho.value;
      factor.slope += rho.first * x * d;
      factor.curvature += (rho.first + 2 * x * x * rho.second) * d * d;
    }
    const double w = weights[row / rows_per_factor];
    phi.value += w * factor.value;
    phi.slope += w * factor.slope;
    phi.curvature += w * factor.curvature;
  }
  return phi;
}

Phi sum_blocks(const FactorBatch& batch, const double* r, const double* Jd, double alpha) {
  Phi phi;
  const int m = batch.residual_dim();
  for (int i = 0; i < batch.size(); ++i, r += m, Jd += m) {
    double s = 0, xd = 0, dd = 0;
    for (int c = 0; c < m; ++c) {
      const double x = r[c] + alpha * Jd[c];
      s += x * x;
      xd += x * Jd[c];
      dd += Jd[c] * Jd[c];
    }
    const Rho rho = batch.loss().rho(s, m);
    phi.value += batch.weight(i) * 0.5 * rho.value;
    phi.slope += batch.weight(i) * rho.first * xd;
    phi.curvature += batch.weight(i) * (rho.first * dd + 2 * rho.second * xd * xd);
  }
  return phi;
}

}  // namespace

Phi phi_of_batch(const FactorBatch& batch, const double* r, const double* Jd, double alpha) {
  const Loss& loss = batch.loss();
  const int m = batch.residual_dim(), rows = batch.size() * m;
  const double* weights = batch.weights();
  if (loss.kind == Loss::Kind::Squared)
    return sum_components(rows, m, weights, r, Jd, alpha, [](double x) { return Rho{x * x, 1, 0}; });
  if (!loss.per_component && m > 1) return sum_blocks(batch, r, Jd, alpha);
  if (loss.kind == Loss::Kind::Huber && !loss.one_sided)
    return sum_components(rows, m, weights, r, Jd, alpha, [a = loss.scale](double x) {
      const double size = std::abs(x);
      return size <= a ? Rho{x * x, 1, 0} : Rho{a * (2 * size - a), a / size, -0.5 * a / (size * x * x)};
    });
  return sum_components(rows, m, weights, r, Jd, alpha, [&](double x) { return loss.rho_of_component(x); });
}

namespace {

Phi phi_of(const Graph& graph, const std::vector<std::vector<double>>& r, const std::vector<std::vector<double>>& Jd, double alpha) {
  Phi phi;
  for (std::size_t b = 0; b < r.size(); ++b) {
    const Phi part = phi_of_batch(*graph.batches()[b], r[b].data(), Jd[b].data(), alpha);
    phi.value += part.value;
    phi.slope += part.slope;
    phi.curvature += part.curvature;
  }
  return phi;
}

}  // namespace

void Irls::Workspace::evaluate_linear(const Graph& graph) {
  const std::size_t batches = graph.batches().size();
  for (auto* arrays : {&r, &J, &Jd}) arrays->resize(batches);
  for (std::size_t b = 0; b < batches; ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    const std::size_t rows = static_cast<std::size_t>(batch.size()) * batch.residual_dim();
    r[b].resize(rows);
    Jd[b].resize(rows);
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

// r and J at the start once; from then on everything happens in the tangent space: x = x⁰ ⊕ total, r = r⁰ + J total.
void Irls::minimize_linear(const Graph& graph, Progress& progress) {
  Workspace& w = *workspace_;
  Summary& summary = progress.summary;
  const Curvature model = curvature(graph, true);
  w.evaluate_linear(graph);
  w.total.assign(w.tangent.size(), 0.0);
  const double first = w.normal.linearize_at(graph, w.r, w.J, model, &w.pool);
  progress.watch.lap(summary.seconds_linearize);
  if (!progress.begin(first, graph, w.resolved, w.best)) return;
  double gradient_norm = max_norm(w.normal.gradient());
  double lambda = 0;
  while (!progress.gradient_is_flat(gradient_norm) && progress.go_on(gradient_norm)) {
    ++summary.iterations;
    if (lambda > 0) w.read_diagonal();
    const double predicted = w.solve_damped(lambda);
    progress.watch.lap(summary.seconds_solve);
    if (!std::isfinite(predicted)) {  // some direction is free: the least bit of damping makes the matrix definite
      lambda = lambda == 0 ? 1e-9 : 10 * lambda;
      if (lambda < 1e9) continue;
      progress.end(Termination::failed, "the normal equations are not positive definite under any damping");
      return;
    }
    w.apply_step(graph);
    const Phi start = phi_of(graph, w.r, w.Jd, 0);
    const double alpha = minimize_along(start, kSlopeAccuracy, [&](double a) { return phi_of(graph, w.r, w.Jd, a); });
    w.move_along(alpha);
    const double before = summary.cost;
    summary.cost = std::min(before, w.normal.linearize_at(graph, w.r, w.J, model, &w.pool));
    progress.watch.lap(summary.seconds_linearize);
    gradient_norm = max_norm(w.normal.gradient());
    if (progress.decrease_is_small(before, summary.cost)) break;
  }
  summary.gradient_norm = gradient_norm;
  w.resolved.retract(w.best, w.total.data(), w.candidate);
  std::swap(w.best, w.candidate);
}

}  // namespace holdfast
