// A factor's part of the normal equations, from its residual, its Jacobian and its loss.
#pragma once

#include <algorithm>
#include <holdfast/graph/factor.hpp>
#include <holdfast/graph/loss.hpp>

namespace holdfast {

#define HOLDFAST_NOINLINE __attribute__((noinline))

/// How a robust term enters H (the gradient is always exact): irls: w ρ' JᵀJ; newton: the second derivative of ½ρ(‖r‖²) with
/// J held, ρ' JᵀJ + 2ρ'' (Jᵀr)(Jᵀr)ᵀ, cut off where it would turn negative; bound: w ρ'(0) JᵀJ, which no concave ρ exceeds.
enum class Curvature { irls, newton, bound };

/// Row weights of one factor: g = Jᵀ diag(gradient) r, H = Jᵀ diag(hessian) J + rank_one (Jᵀr)(Jᵀr)ᵀ.
template <int M>
struct RowWeights {
  Vector<M> gradient;
  Vector<M> hessian;
  double rank_one;
  double cost;
};

/// Newton's curvature is never less than this part of the IRLS one: keeps H positive definite on the flat part of a loss.
constexpr double kLeastCurvature = 1e-5;

template <int M>
RowWeights<M> row_weights(const Loss& loss, double weight, const Vector<M>& r, Curvature curvature) {
  RowWeights<M> w;
  w.rank_one = 0;
  if (loss.kind == Loss::Kind::Squared) {
    w.gradient.setConstant(weight);
    w.hessian.setConstant(weight);
    w.cost = 0.5 * weight * r.squaredNorm();
    return w;
  }
  if (loss.per_component || M == 1) {
    double sum = 0;
    for (int c = 0; c < M; ++c) {
      const Rho rho = loss.rho_of_component(r[c]);
      sum += rho.value;
      w.gradient[c] = weight * rho.first;
      w.hessian[c] = curvature == Curvature::newton
                         ? weight * std::max(rho.first + 2 * r[c] * r[c] * rho.second, kLeastCurvature * rho.first)
                         : w.gradient[c];
    }
    if (curvature == Curvature::bound) w.hessian.setConstant(weight * loss.rho(0, 1).first);
    w.cost = 0.5 * weight * sum;
    return w;
  }
  const double s = r.squaredNorm();
  const Rho rho = loss.rho(s, M);
  w.gradient.setConstant(weight * rho.first);
  w.hessian.setConstant(weight * (curvature == Curvature::bound ? loss.rho(0, M).first : rho.first));
  if (curvature == Curvature::newton && s > 0) w.rank_one = weight * std::max(2 * rho.second, -(1 - kLeastCurvature) * rho.first / s);
  w.cost = 0.5 * weight * rho.value;
  return w;
}

/// A factor's part of the normal equations from its residual and Jacobian (M × N, column-major). It depends on the sizes only, so that
/// factor types of equal sizes share the code.
template <int M, class Vars>
struct NormalBlocks {
  static constexpr int N = Vars::total_dim;
  static constexpr int K = Vars::size;

  /// Blocks (a, b), a ≥ b; gradient; cost.
  HOLDFAST_NOINLINE static void write(const double* r, const double* J, const RowWeights<M>& w, double* out) {
    double rows[M * N];  // J row by row: what is summed up below is then contiguous
    for (int m = 0; m < M; ++m)
      for (int n = 0; n < N; ++n) rows[m * N + n] = J[n * M + m];
    double* const begin = out;
    out = column<0, 0>(rows, w, out);
    if (w.rank_one != 0) add_rank_one(r, rows, w.rank_one, begin);
    std::fill(out, out + N, 0.0);
    for (int m = 0; m < M; ++m)
      for (int n = 0; n < N; ++n) out[n] += rows[m * N + n] * (w.gradient[m] * r[m]);
    out[N] = w.cost;
  }

 private:
  template <int A, int B>
  static double* column(const double* rows, const RowWeights<M>& w, double* out) {
    if constexpr (B == K) {
      return out;
    } else if constexpr (A == K) {
      return column<B + 1, B + 1>(rows, w, out);
    } else {
      constexpr int R = Vars::dims[A], C = Vars::dims[B];
      for (int c = 0; c < C; ++c) {
        double sum[R] = {};
        for (int m = 0; m < M; ++m) {
          const double scaled = w.hessian[m] * rows[m * N + Vars::offsets[B] + c];
          for (int k = 0; k < R; ++k) sum[k] += rows[m * N + Vars::offsets[A] + k] * scaled;
        }
        std::copy_n(sum, R, out + c * R);
      }
      return column<A + 1, B>(rows, w, out + R * C);
    }
  }

  static void add_rank_one(const double* r, const double* rows, double weight, double* out) {
    double v[N] = {};  // Jᵀ r
    for (int m = 0; m < M; ++m)
      for (int n = 0; n < N; ++n) v[n] += rows[m * N + n] * r[m];
    for (int b = 0; b < K; ++b)
      for (int a = b; a < K; ++a)
        for (int c = 0; c < Vars::dims[b]; ++c)
          for (int k = 0; k < Vars::dims[a]; ++k) *out++ += weight * v[Vars::offsets[a] + k] * v[Vars::offsets[b] + c];
  }
};

}  // namespace holdfast
