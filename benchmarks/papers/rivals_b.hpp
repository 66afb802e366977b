// Paper B's three filters: interacting multiple models (imm.hpp) of constant velocity and of turns at ±2°/s, with Π = 0.4 / 0.3 / 0.3,
// Q = q I, P₀ = 0.1 I, and what differs in how one of them corrects:
//
//   KF     position, R
//   EKF    [√(x² + y²), atan2(y, x)] seen from the origin, the same R for metres and radians, as printed
//   ARKF   e = R^{-1/2} r; M = diag exp(−e_i²/2σ₁²), θ_ij = exp(−(e_i − e_j)²/2σ₂²), N = diag(Σ_j θ_ij) − θ                (22)–(26)
//          Γ = h/σ₁² M + 2(1−h)/σ₂² N,  R̄⁻¹ = R^{-1/2} Γ R^{-1/2}                                                         (27) (28)
//          where rᵀ S⁻¹ r > χ² = 5.991 with S = H P⁻ Hᵀ + R̄: P⁻ = λ F P Fᵀ + Q with λ ≥ 1 raised by Newton until it is not    (29)–(32)
//
// The test never fails: rᵀ S⁻¹ r ≤ eᵀ Γ e ≤ 1.5 for any residual. Kernels below 1e-9 are 1e-9: as printed, a sample far off makes Γ
// singular. Errata (docs/paper_b.md): a minus in (24), a plus in (32), F P Fᵀ in its denominator.
#pragma once

#include <holdfast/benchmarks/papers/flight.hpp>
#include <holdfast/benchmarks/papers/imm.hpp>

namespace holdfast::bench {

enum class FilterB { kf, ekf, arkf };

struct FilterBOptions {
  FilterB kind = FilterB::kf;
  double R = 0.5;   ///< [m²]
  double q = 0.01;  ///< Q = q I
};

class ImmB {
 public:
  /// Starts at `state`, with the mode probabilities 0.4, 0.3, 0.3.
  ImmB(const FilterBOptions& options, const Motion2& state);
  void step(const Vector<2>& gps);
  Gaussian<4> state() const { return filters_.state(); }
  const Vector<3>& probabilities() const { return filters_.probabilities; }
  int chi_square_alarms() const { return alarms_; }  ///< how often λ > 1

 private:
  Filtered<4> filtered(const Gaussian<4>& before, const Matrix<4, 4>& F, const Vector<2>& gps);
  Filtered<4> corrected_by_range_and_bearing(const Gaussian<4>& prior, const Vector<2>& gps) const;
  Filtered<4> corrected_adaptively(const Gaussian<4>& before, const Matrix<4, 4>& F, const Vector<2>& gps);

  const FilterBOptions options_;
  const Matrix<4, 4> Q_;
  const Matrix<2, 2> R_, W_;  ///< W = R^{-1/2}
  std::array<Matrix<4, 4>, 3> F_;
  Imm<4, 3> filters_;
  int alarms_ = 0;
};

/// R̄ of (28) for the residual r and W = R^{-1/2}.
Matrix<2, 2> adapted_covariance(const Vector<2>& r, const Matrix<2, 2>& W);

}  // namespace holdfast::bench
