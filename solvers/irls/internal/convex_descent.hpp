// Descent on a convex problem whose factors bend: a semismooth Newton method with the factors' own Hessians. Internal.
#pragma once

#include <holdfast/solvers/internal/minimizer.hpp>
#include <holdfast/solvers/irls/internal/quadratic_model.hpp>

namespace holdfast::detail {

class ConvexDescent {
 public:
  /// True where every factor and every loss is convex, and some factor says hessian(): there JᵀJ is a poor model of the cost.
  static bool serves(const Graph& graph);

  explicit ConvexDescent(const Values& values) : candidate_(values) {}

  /// From `values` to the answer: (H + λ D) δ = −g with H the generalised Hessian (Curvature::exact; semidefinite, since all is
  /// convex) and D the largest that its diagonal has been: where a variable is nearly free, λ diag H would let it go far, and one such
  /// makes steps short for all. The step is t δ with t = 1, ½, ¼, … until f(x ⊕ tδ) ≤ f(x) + 10⁻⁴ t gᵀδ (Armijo). λ begins at 1, falls
  /// tenfold after a whole step, to 0 in the end, and grows threefold after a cut.
  /// It ends as converged only where the model with next to no damping (λ ≤ 1e-6), too, predicts less than cost_tolerance of the cost: a
  /// damped step is short far from the minimum, too.
  /// No first-order steps come first: on networks of 10³ to 10⁵ nodes they took longer than the Newton steps that they spared.
  void minimize(const Graph& graph, QuadraticModel& system, Values& values, Progress& progress);

 private:
  enum class Step { goes_on, short_of_decrease, nothing_predicted, nothing_lower, failed };

  double predict_undamped(QuadraticModel& system, Progress& progress);
  bool is_at_minimum(QuadraticModel& system, Step taken, double before, Progress& progress);
  void update_scales(const QuadraticModel& system);
  Step step(const Graph& graph, QuadraticModel& system, Values& values, Progress& progress);
  /// The step length, or 0; `candidate_` is where it leads, `cost` the cost there.
  double search(const Graph& graph, QuadraticModel& system, const Values& values, double before, double slope, double& cost);

  Values candidate_;
  std::vector<double> step_, scales_;
  double lambda_ = 0;
};

}  // namespace holdfast::detail
