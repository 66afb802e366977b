// Interacting multiple models (Blom & Bar-Shalom 1988; paper B, eq. 4–13 with notes D.B.2): K filters that exchange their states.
//
//   c_i = Σ_j Π_ji μ_j                                        predicted probability of model i                    (4)
//   μ_{j|i} = Π_ji μ_j / c_i                                  who it was before                                   (7)
//   x̄_i = Σ_j μ_{j|i} x_j,  P̄_i = Σ_j μ_{j|i} (P_j + (x_j − x̄_i)(x_j − x̄_i)ᵀ)                          (8) (9)
//   each model filters from there; its likelihood Λ_i = N(r_i; 0, S_i)                                            (10)
//   μ_i = c_i Λ_i / Σ_j c_j Λ_j                                                                                   (11)
//   mixture: mean Σ μ_i x_i, covariance Σ μ_i (P_i + (x_i − x)(x_i − x)ᵀ)                                   (12) (13)
#pragma once

#include <array>
#include <holdfast/benchmarks/papers/kalman.hpp>

namespace holdfast::bench {

/// What one model's filter makes of a step.
template <int N>
struct Filtered {
  Gaussian<N> state;
  double log_likelihood;
};

/// The Gaussian with the moments of a mixture.
template <int N, int K>
Gaussian<N> mixture(const std::array<Gaussian<N>, K>& parts, const Vector<K>& weights) {
  Gaussian<N> all{parts[0].mean * weights[0], parts[0].covariance * weights[0]};
  for (int i = 1; i < K; ++i) {
    all.mean += weights[i] * parts[i].mean;
    all.covariance += weights[i] * parts[i].covariance;
  }
  for (int i = 0; i < K; ++i) {
    const Vector<N> apart = parts[i].mean - all.mean;
    all.covariance.noalias() += weights[i] * apart * apart.transpose();
  }
  return all;
}

template <int N, int K>
struct Imm {
  Matrix<K, K> transition;  ///< Π_ji: from model j to model i in one step
  Vector<K> probabilities;
  std::array<Gaussian<N>, K> models;

  Gaussian<N> state() const { return mixture<N, K>(models, probabilities); }

  /// filter(i, prior) predicts and corrects model i from its mixed prior: Filtered<N>.
  template <class Filter>
  void step(const Filter& filter) {
    const Vector<K> prior = transition.transpose() * probabilities;
    std::array<Gaussian<N>, K> mixed;
    for (int i = 0; i < K; ++i) mixed[i] = mixture<N, K>(models, transition.col(i).cwiseProduct(probabilities) / prior[i]);
    Vector<K> log_weights;
    for (int i = 0; i < K; ++i) {
      const Filtered<N> filtered = filter(i, mixed[i]);
      models[i] = filtered.state;
      log_weights[i] = std::log(prior[i]) + filtered.log_likelihood;
    }
    // Relative to the largest: far from every model all likelihoods would underflow.
    probabilities = (log_weights.array() - log_weights.maxCoeff()).exp();
    probabilities /= probabilities.sum();
  }
};

}  // namespace holdfast::bench
