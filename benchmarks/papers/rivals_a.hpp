// Paper A's own estimators, as the paper has them: Q = R = P₀ = I whatever the noise, the first measurement as the first position, at rest.
// At a step without any measurement all of them predict, F^m x̂.
#pragma once

#include <holdfast/benchmarks/papers/chain.hpp>
#include <holdfast/benchmarks/papers/pursuit.hpp>

namespace holdfast::bench {

/// The Kalman filter over m missing steps: P^{[m]} = F^m P* F^{mᵀ} + G^{[m]} R G^{[m]ᵀ}.
Positions kalman_a(const Pursuit& pursuit);

struct WindowedOptions {
  ChainLosses losses;
  /// Whitens the motion between two measured states: recursive, P^{[m]} (7); or paper, G^{[m]} R G^{[m]ᵀ} (5).
  WhiteAcceleration<Motion2>::Kind motion = WhiteAcceleration<Motion2>::Kind::recursive;
  /// The first state is tied to F^m x̂ of the one before the window, with P^{[m]} (7); else the graph is trimmed there, as in its text.
  bool anchored = false;
  std::size_t window = 15;  ///< measured states
  std::string backend = "irls";
};
/// (9) element by element with a = 2: the paper's robust estimator.
ChainLosses robust_losses();
/// (7), (8): batched least squares.
ChainLosses least_squares_losses();
/// The sum of norms of Laplacian parts o, ½‖r − o‖² + λ‖o‖, minimised over o: Huber with a = λ on the whole residual.
ChainLosses sum_of_norms_losses(double lambda);

/// min over the latest `window` measured states, at every measurement; the last state is the estimate.
Positions windowed_a(const Pursuit& pursuit, const WindowedOptions& options);

}  // namespace holdfast::bench
