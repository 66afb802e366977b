#include <algorithm>
#include <cmath>
#include <holdfast/solvers/irls/internal/workspace.hpp>

namespace holdfast {
namespace {

constexpr double kLeastDiagonal = 1e-12;  // an unconstrained direction must feel the damping, too

}  // namespace

Irls::Workspace::Workspace(const Graph& graph, const Values& values, int threads)
    : resolved(graph, values),
      symbolic(analyze(block_graph(graph, resolved, variable))),
      normal(graph, resolved, variables_in_order()),
      cholesky(std::move(symbolic), normal.pattern()),
      gradients(graph),
      pool(threads),
      best(values),
      candidate(values) {
  const std::size_t n = resolved.tangent_dim();
  for (std::vector<double>* v : {&damping, &diagonal, &rhs, &step, &tangent, &bend, &acceleration, &newton, &steepest, &H_steepest})
    v->resize(n);
  for (const Resolved::Batch& batch : resolved.batches()) {
    offsets.emplace_back();
    for (int v : batch.variable) offsets.back().push_back(resolved.variables()[v].offset);
  }
}

std::vector<int> Irls::Workspace::variables_in_order() const {
  std::vector<int> order;
  for (int node : symbolic.order) order.push_back(variable[node]);
  return order;
}

void Irls::Workspace::read_diagonal() {
  const BlockPattern& pattern = normal.pattern();
  for (int i = 0; i < pattern.size(); ++i) {
    const double* block = &normal.H()[pattern.block_begin[pattern.column_begin[i]]];
    for (int c = 0; c < pattern.dims[i]; ++c) diagonal[pattern.offsets[i] + c] = block[c * (pattern.dims[i] + 1)];
  }
}

double Irls::Workspace::solve_damped(double lambda) {
  for (std::size_t i = 0; i < damping.size(); ++i) damping[i] = lambda * std::max(diagonal[i], kLeastDiagonal);
  if (!cholesky.factor(normal.H(), damping, &pool)) return NAN;
  const std::vector<double>& g = normal.gradient();
  for (std::size_t i = 0; i < rhs.size(); ++i) rhs[i] = -g[i];
  cholesky.solve(rhs, step);
  double predicted = 0;
  for (std::size_t i = 0; i < step.size(); ++i) predicted += 0.5 * step[i] * (damping[i] * step[i] - g[i]);
  return predicted;
}

// Transtrum & Sethna 2012: the residuals along x ⊕ (tδ + ½t²a) stay on their tangent plane to second order where H a = −Jᵀ W r̈.
bool Irls::Workspace::accelerate(const Graph& graph) {
  constexpr double h = 0.1;
  constexpr double kMostBend = 0.25;  // ‖a‖ / ‖δ‖ in the metric of diag H: beyond it the second order is no better than the first
  for (std::size_t i = 0; i < tangent.size(); ++i) acceleration[i] = h * tangent[i];
  resolved.retract(best, acceleration.data(), candidate);
  gradients.curvature(graph, resolved, best, candidate, h, tangent.data(), offsets, bend, &pool);
  normal.from_tangent(resolved, bend.data(), rhs.data());
  for (double& x : rhs) x = -x;
  cholesky.solve(rhs, acceleration);
  double a2 = 0, d2 = 0;
  for (std::size_t i = 0; i < step.size(); ++i) {
    a2 += diagonal[i] * acceleration[i] * acceleration[i];
    d2 += diagonal[i] * step[i] * step[i];
  }
  if (!(a2 <= kMostBend * kMostBend * d2)) return false;
  for (std::size_t i = 0; i < step.size(); ++i) acceleration[i] = step[i] + 0.5 * acceleration[i];
  normal.to_tangent(resolved, acceleration.data(), tangent.data());
  return true;
}

}  // namespace holdfast
