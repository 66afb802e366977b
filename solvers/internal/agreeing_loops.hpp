// Loop closures that another one agrees with: a cheap look at pairs that lie close together, before anything is solved. Internal.
//
// Two relative poses z₁: i → j and z₂: k → l, with k a few poses from i and l a few from j, close a small ring with the trusted edges
// between them:
//
//   E = z₁⁻¹ T_ik z₂ T_lj        agree:  ‖t(E)‖²/σ_t² + θ(E)²/σ_θ²  ≤  the 99.9 % quantile of χ²
//
// The stretches T are at most kReach trusted edges long, so little has drifted: two random false loops agree with a probability of about
// the ring's uncertainty over the size of the map, and true loops come in groups. Variances are the largest of each edge's covariance, and
// add up along the stretches with their levers: on the safe side, so that true loops agree. Against false loops made to agree with each
// other it is no help: solvers/pairwise_consistency.hpp.
#pragma once

#include <holdfast/graph/graph.hpp>

namespace holdfast::detail {

/// Of each candidate: with how many others it agrees, 0 where it is no relative pose. Every other relative pose of weight > 0 is trusted.
std::vector<int> agreements(const Graph& graph, const std::vector<FactorId>& candidates);

}  // namespace holdfast::detail
