// The cost of a linear problem along one direction: φ(α) = Σ w ½ρ(‖r + α Jd‖²), with its first two derivatives. Internal.
#pragma once

#include <holdfast/graph/graph.hpp>

namespace holdfast::detail {

struct Phi {
  double value = 0;
  double slope = 0;
  double curvature = 0;

  Phi& operator+=(const Phi& other) {
    value += other.value;
    slope += other.slope;
    curvature += other.curvature;
    return *this;
  }
};

inline double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

/// The part of φ(α) of consecutive rows under one loss; block: the residual dimension of a factor; weights: of each row's factor.
Phi phi_of_rows(const Loss& loss, int rows, int block, const double* weights, const double* r, const double* Jd, double alpha);
/// The same of all rows of a batch.
Phi phi_of_batch(const FactorBatch& batch, const double* weights, const double* r, const double* Jd, double alpha);
/// The weight of each row's factor, for all rows of a batch.
void weights_of_rows(const FactorBatch& batch, double* weights);

/// The α > 0 that minimises φ along a descent direction, to a slope of `accuracy` times the first one: a safeguarded Newton iteration from
/// α = 1. start: value and slope at 0; evaluate(α) = φ(α). What is returned has φ(α) ≤ φ(0) but for rounding, or is 0: near a minimum
/// values no longer differ, and slopes still do.
/// Where Newton leaves the bracket the next α is where the tangents at its ends meet: of a convex φ it lies inside, and one such step
/// comes back from far out on a slope that has saturated.
template <class Evaluate>
double minimize_along(const Phi& start, double accuracy, const Evaluate& evaluate) {
  const double equal = start.value + 1e-14 * std::abs(start.value);
  double low = 0, high = -1;  // the slope is negative at low, positive at high
  Phi at_low = start, at_high;
  double alpha = 1, best = 0, best_value = start.value, width = -1;
  for (int i = 0; i < 50; ++i) {
    const Phi phi = evaluate(alpha);
    if (phi.value < best_value) {
      best_value = phi.value;
      best = alpha;
    }
    if (std::abs(phi.slope) <= accuracy * std::abs(start.slope) && phi.value <= equal) return alpha;
    const bool beyond = phi.slope >= 0 || phi.value > equal;
    (beyond ? high : low) = alpha;
    (beyond ? at_high : at_low) = phi;
    const double newton = alpha - phi.slope / phi.curvature;
    if (high < 0) {
      alpha = newton > 1.1 * alpha && newton < 10 * alpha ? newton : 3 * alpha;
      continue;
    }
    if (high - low < 1e-12 * high) break;
    const double meet = (at_high.value - at_low.value - at_high.slope * high + at_low.slope * low) / (at_low.slope - at_high.slope);
    const bool halved = width < 0 || high - low <= 0.5 * width || i % 2 == 0;
    width = high - low;
    if (newton > low && newton < high && halved)
      alpha = newton;
    else if (meet > low && meet < high && halved)
      alpha = meet;
    else
      alpha = 0.5 * (low + high);
  }
  return best;
}

}  // namespace holdfast::detail
