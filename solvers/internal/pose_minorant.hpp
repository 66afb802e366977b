// A quadratic function below the cost of a relative pose, for the certificate (solvers/certificate.hpp). Internal.
//
// A pose is n + 1 rows of n numbers, Z = [Rᵀ; pᵀ]: the columns of R, then p. With y = R_aᵀ(p_b − p_a) − t and E = R_zᵀ R_aᵀ R_b both
// ‖y‖² and ⟨G, y⟩ are quadratic in the rows of a and b, and E is bilinear in them. The cost of the edge is ½ eᵀΛe with
// e = (R_zᵀ y, φ), φ = Log E. At the values at hand (index 0) it is replaced, from below, by
//
//   joint     ½eᵀΛe ≥ ½eᵀDe + ⟨(Λ − D)e₀, e⟩ − ½e₀ᵀ(Λ − D)e₀     D = (1 − ρ) diag(λ_min(Λ_tt) I, Λ_rr) ≤ Λ, ρ: canonical correlation
//   rotation  ½κθ² ≥ ½κθ₀² + κ (θ₀ / sin θ₀)(cos θ₀ − cos θ)        θ² is a convex function of 1 − cos θ; of Λ_rr the part κ = λ_min
//             ½φᵀΩφ = tr A(I − E) + ψ(φ), A = ½ tr(Ω) I − Ω          rest Ω = Λ_rr − κI (in space); ψ(φ) = φᵀΩφ (½ − (1 − cos θ)/θ²)
//             ψ(φ) ≥ ψ₀ + ⟨v, δ⟩ sin|δ|/|δ| − a (1 − cos|δ|)          Exp δ = E₀ᵀE, v the gradient, a = 0.016 θ₀²(1 + θ₀²) tr Ω
//             ⟨g, φ⟩ ≥ ⟨g, φ₀⟩ + ⟨v, δ⟩ sin|δ|/|δ| − c|g| (1 − cos|δ|)  c = 1.05 (x − sin x)/(1 − cos x), x = π + θ₀
//
// each with equality and the same gradient there. The two constants hold for θ₀ ≤ 1.5 (found by search over all directions; the test
// draws at random). Beyond it, and in the plane beyond 3, the rotation keeps ½κ·2(1 − cos θ) ≤ ½κθ² alone: below, but not equal.
#pragma once

#include <holdfast/graph/batch.hpp>
#include <holdfast/graph/variables.hpp>

namespace holdfast::detail {

/// ½⟨Z, K Z⟩ + constant, Z = [Z_a; Z_b].
template <class Pose>
struct PoseMinorant {
  static constexpr int n = Pose::space_dim;
  static constexpr int rows = n + 1;
  using Rows = Matrix<2 * rows, n>;
  Matrix<2 * rows, 2 * rows> K = Matrix<2 * rows, 2 * rows>::Zero();
  double constant = 0;

  static Rows rows_of(const Pose& a, const Pose& b) {
    Rows Z;
    Z << a.rotation().transpose(), a.p.transpose(), b.rotation().transpose(), b.p.transpose();
    return Z;
  }
  double operator()(const Pose& a, const Pose& b) const {
    const Rows Z = rows_of(a, b);
    return constant + 0.5 * Z.cwiseProduct(K * Z).sum();
  }
};

/// Below ½eᵀΛe everywhere, equal at (a, b) but for large angles, see above.
template <class Pose>
PoseMinorant<Pose> minorant_at(const MeasuredPose<Pose>& measured, double weight, const Pose& a, const Pose& b);

/// ½τ‖y‖² + ½κ·2(1 − cos θ), the chordal cost with isotropic weights: the harmonic means of the eigenvalues of the information's two
/// diagonal blocks (SE-Sync's).
template <class Pose>
PoseMinorant<Pose> chordal_form(const MeasuredPose<Pose>& measured, double weight);

/// The same with weights so small that it lies below ½eᵀΛe everywhere: (1 − ρ) λ_min of the two blocks. Touches it where e = 0.
template <class Pose>
PoseMinorant<Pose> chordal_form_below(const MeasuredPose<Pose>& measured, double weight);

/// Whether the information is diag(τI, κI) to 1e-9 of its largest entry.
template <class Pose>
bool is_isotropic(const Matrix<Pose::dim, Pose::dim>& information);

}  // namespace holdfast::detail
