// How a factor's loss weighs the rows of its Jacobian in the normal equations.
#pragma once

#include <algorithm>
#include <holdfast/graph/factor.hpp>
#include <holdfast/graph/loss.hpp>

namespace holdfast {

/// How a robust term enters H (the gradient is always exact):
///   irls    w ρ' JᵀJ
///   newton  the second derivative of ½ρ(‖r‖²) with J held, w(ρ' JᵀJ + 2ρ'' (Jᵀr)(Jᵀr)ᵀ), cut off where it would turn negative
///   bound   w ρ'(0) JᵀJ, which no concave ρ exceeds
///   exact   newton with the factor's own hessian() in place of JᵀJ, where it has one (factor.hpp). Under a loss per component of a
///           residual of several components newton: what each component bends by itself is not known. Positive semidefinite where
///           the factors with a hessian() are convex; with others H may be indefinite, and whoever asks must damp it
enum class Curvature { irls, newton, bound, exact };

/// Newton's curvature is never less than this part of the IRLS one: keeps H positive definite on the flat part of a loss.
constexpr double kLeastCurvature = 1e-5;

/// Of one factor: g = Jᵀ diag(gradient) r, H = Jᵀ diag(hessian) J + rank_one (Jᵀr)(Jᵀr)ᵀ, where gradient and hessian are the row weights.
struct TermWeight {
  double rank_one = 0;
  double cost = 0;
};

/// Writes the m row weights. M: m, or Eigen::Dynamic.
template <int M>
TermWeight row_weights(const Loss& loss, double weight, const double* r, int m, Curvature curvature, double* gradient, double* hessian) {
  const Eigen::Map<const Vector<M>> residual(r, m);
  const int rows = M == Eigen::Dynamic ? m : M;
  const bool newton = curvature == Curvature::newton || curvature == Curvature::exact;
  if (loss.kind == Loss::Kind::Squared) {
    std::fill(gradient, gradient + rows, weight);
    std::fill(hessian, hessian + rows, weight);
    return {0, 0.5 * weight * residual.squaredNorm()};
  }
  if (loss.per_component || rows == 1) {
    double sum = 0;
    for (int c = 0; c < rows; ++c) {
      const Rho rho = loss.rho_of_component(r[c]);
      sum += rho.value;
      gradient[c] = weight * rho.first;
      hessian[c] = newton ? weight * std::max(rho.first + 2 * r[c] * r[c] * rho.second, kLeastCurvature * rho.first) : gradient[c];
    }
    if (curvature == Curvature::bound) std::fill(hessian, hessian + rows, weight * loss.rho(0, 1).first);
    return {0, 0.5 * weight * sum};
  }
  const double s = residual.squaredNorm();
  const Rho rho = loss.rho(s, rows);
  std::fill(gradient, gradient + rows, weight * rho.first);
  std::fill(hessian, hessian + rows, weight * (curvature == Curvature::bound ? loss.rho(0, rows).first : rho.first));
  TermWeight w{0, 0.5 * weight * rho.value};
  if (newton && s > 0) w.rank_one = weight * std::max(2 * rho.second, -(1 - kLeastCurvature) * rho.first / s);
  return w;
}

}  // namespace holdfast
