// The cost of a linear problem along one direction: φ(α) = Σ w ½ρ(‖r + α Jd‖²), with its first two derivatives. Internal.
#pragma once

#include <holdfast/graph/graph.hpp>

namespace holdfast {

struct Phi {
  double value = 0;
  double slope = 0;
  double curvature = 0;
};

/// One batch's part of φ(α); r and Jd: residual_dim doubles a factor.
Phi phi_of_batch(const FactorBatch& batch, const double* r, const double* Jd, double alpha);

/// The α > 0 that minimises φ along a descent direction, to a slope of `accuracy` times the first one: a safeguarded Newton iteration from
/// α = 1. φ(α) evaluates; the value returned is of a point with φ(α) ≤ φ(0), or α = 0.
template <class Evaluate>
double minimize_along(const Phi& start, double accuracy, const Evaluate& evaluate) {
  double low = 0, high = -1;  // the slope is negative at low, positive at high
  double alpha = 1, best = 0, best_value = start.value;
  for (int i = 0; i < 50; ++i) {
    const Phi phi = evaluate(alpha);
    if (phi.value < best_value) {
      best_value = phi.value;
      best = alpha;
    }
    if (std::abs(phi.slope) <= accuracy * std::abs(start.slope) && phi.value <= start.value) return alpha;
    (phi.slope < 0 && phi.value <= start.value ? low : high) = alpha;
    const double newton = alpha - phi.slope / phi.curvature;
    if (high < 0)
      alpha = newton > 1.1 * alpha && newton < 10 * alpha ? newton : 3 * alpha;
    else
      alpha = newton > low + 0.05 * (high - low) && newton < high - 0.05 * (high - low) ? newton : 0.5 * (low + high);
    if (high > 0 && high - low < 1e-12 * high) break;
  }
  return best;
}

}  // namespace holdfast
