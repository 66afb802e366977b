// Descent where every factor is linear: r and J at the start once; from then on everything happens in the tangent space,
// x = x⁰ ⊕ total, r = r⁰ + J total, and the line search along a step is exact and costs next to nothing. Internal.
#pragma once

#include <algorithm>
#include <cmath>
#include <holdfast/solvers/internal/minimizer.hpp>
#include <holdfast/solvers/irls/internal/line_search.hpp>
#include <holdfast/solvers/irls/internal/newton_system.hpp>

namespace holdfast::detail {

/// A linear problem too wide for LinearRows: blocks in fronts. The same interface.
class LinearFronts {
 public:
  explicit LinearFronts(NewtonSystem& system) : system_(system), offsets_(tangent_offsets(system.resolved())) {}

  /// Evaluates residuals and Jacobians at these values.
  void load(const Graph& graph, const Values& values);

  const Resolved& resolved() const { return system_.resolved(); }
  double linearize(const Graph& graph, Curvature curvature) { return system_.linearize_at(graph, r_, J_, curvature); }
  const std::vector<double>& gradient() const { return system_.gradient(); }
  double solve_damped(double lambda) { return system_.solve_damped(lambda, step_); }
  void apply_step(const Graph& graph);  ///< J δ
  double slope() const { return dot(system_.gradient(), step_); }
  Phi phi(const Graph& graph, double alpha) const;
  void move_along(double alpha);
  /// values ⊕ the whole way.
  void retract(Values& values) const { resolved().retract(values, total_.data(), values); }

 private:
  NewtonSystem& system_;
  std::vector<std::vector<int>> offsets_;
  std::vector<std::vector<double>> r_, J_, Jd_, row_weights_;  // of each batch
  std::vector<double> step_, tangent_, total_;
};

/// Model: LinearRows or LinearFronts, loaded at `start`.
template <class Model>
void descend_linear(const Graph& graph, const Values& start, Model& model, Curvature kind, double cost_tolerance, Progress& progress) {
  constexpr double kSlopeAccuracy = 0.3;  // of the line search: the next Newton step mends the rest
  constexpr double kStalled = 1e-14;      // relative decrease of the cost that is rounding
  Summary& summary = progress.summary;
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
    if (predicted <= cost_tolerance * before || before - summary.cost <= kStalled * before) {
      progress.end(Termination::converged, "the relative decrease of the cost is within cost_tolerance");
      break;
    }
  }
  summary.gradient_norm = gradient_norm;
}

}  // namespace holdfast::detail
