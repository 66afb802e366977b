// Dynamic covariance scaling (Agarwal, Tipaldi, Spinello, Stachniss & Burgard, "Robust map optimization using dynamic covariance scaling",
// ICRA 2013), as a loss: what contradicts the others gets a larger covariance, by a scaling in closed form. With Φ = c²,
//
//   scaling  a(s) = min(1, 2Φ / (Φ + s)),     weight  ρ'(s) = a(s)²,     ρ(s) = s for s ≤ Φ, else Φ (3s − Φ) / (Φ + s)
//
//   graph.add(loop, keys, DynamicCovarianceScaling{1});   // Φ = 1, the paper's; c is where the scaling begins [sigmas]
//
// The paper gives the weight alone. ρ is its integral, since 4Φ²/(Φ + s)² is the derivative of Φ (3s − Φ)/(Φ + s), which is Φ at s = Φ: so
// solvers that compare costs compare those of the weights they step with. (g2o and GTSAM score other costs: see docs/coming_from.md.)
// ρ levels out at 3Φ; beyond the threshold it is Geman and McClure's 4Φ s/(Φ + s) less Φ.
//
// For files and command lines "dcs:1" after register_loss<DynamicCovarianceScaling>(), which the program `holdfast` calls.
#pragma once

#include <cmath>
#include <holdfast/graph/error.hpp>
#include <holdfast/graph/loss.hpp>

namespace holdfast {

struct DynamicCovarianceScaling {
  double c = 1;  ///< > 0 [sigmas]: √Φ

  Rho rho(double s) const {
    const double phi = c * c;
    if (s <= phi) return {s, 1, 0};
    const double u = phi / (phi + s);
    return {3 * phi - 4 * phi * u, 4 * u * u, -8 * u * u * u / phi};
  }
  Huber relaxed() const { return {c}; }
  void validate() const { Loss(relaxed()).validate(1); }
  static const char* name() { return "dcs"; }
  double scale() const { return c; }
};

}  // namespace holdfast
