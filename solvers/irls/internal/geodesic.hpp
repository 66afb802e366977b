// Geodesic acceleration (Transtrum & Sethna 2012): the second order of the way that keeps residuals on their tangent plane. Internal.
#pragma once

#include <holdfast/graph/gradient.hpp>
#include <holdfast/solvers/irls/internal/newton_system.hpp>

namespace holdfast::detail {

class Geodesic {
 public:
  Geodesic(const Graph& graph, const NewtonSystem& system);

  /// Along x ⊕ (tδ + ½t²a), H a = −Jᵀ W r̈, the residuals r(t) have no curvature within the range of J; r̈ by a difference along δ.
  /// Turns `tangent` from δ into δ + ½a; false, and nothing is done, where ‖a‖ is more than a quarter of ‖δ‖ in the metric of diag H: there
  /// the second order is no better than the first. step: δ in elimination order; at: where the system was linearised and factored;
  /// moved: scratch of the same structure.
  bool bend(const Graph& graph, NewtonSystem& system, const Values& at, const std::vector<double>& step, std::vector<double>& tangent,
            Values& moved);

 private:
  GradientEvaluator gradients_;
  std::vector<std::vector<int>> offsets_;
  std::vector<double> ahead_, curvature_, rhs_, acceleration_;
};

}  // namespace holdfast::detail
