// Ours on paper C's networks: all steps together, exact ranges and bearings, motion with an unknown noise, and no initial guess.
#pragma once

#include <holdfast/benchmarks/papers/network_graph.hpp>
#include <holdfast/solvers/convex_start.hpp>

namespace holdfast::bench {

/// Motion: white jerk between the steps of a node (a target may turn), its density q [m²/s⁵] the same for all nodes and learned from the
/// packets alone: the q of greatest evidence, where the motion's residuals are as large as expected,
///
///   E‖W(q)(F x_k − x_{k+1})‖² = the number of components,   expectation over the posterior (the fixed point of EM),
///
/// found by bisection of log q between kLeastDensity and kGreatestDensity to a factor of kDensityStep; at the border where there is none.
struct NetworkSmoother {
  std::string backend = "irls";
  Missing missing = Missing::nothing;
  double density = 0;  ///< of the jerk [m²/s⁵]; 0: learned
};

inline constexpr double kLeastDensity = 1e-4, kGreatestDensity = 10, kDensityStep = 1.5;

template <int S>
struct SmoothedNetwork {
  Tracks<S> tracks;
  ConvexStart start;  ///< of the first solve, at the middle density
  double density;     ///< [m²/s⁵]
  double anees;       ///< mean over the nodes, at the middle step, of eᵀ P⁻¹ e / S, e the error of a position, P its covariance
  double seconds;     ///< all of it
};

/// Throws BadProblem where a solve fails.
template <int S>
SmoothedNetwork<S> smooth(const Network<S>& network, const NetworkSmoother& recipe);

}  // namespace holdfast::bench
