// The recursive estimator that paper C compares with: Hu, Wang, Liu & Gao, "A variance-constrained approach to recursive state estimation
// for time-varying complex networks with missing measurements", Automatica 64 (2016). As far as it is defined there for our problem:
//
//   x_i(t) = x_i(t−1) + w,  w ~ N(0, β² I)            nodes are not coupled in C's motion, and have no velocity
//   y_i(t) = λ x_i(t) + v                             λ = 1 with probability 1 − p, else 0: nothing but noise arrives
//   x̂⁻ = x̂(t−1),            P⁻ = P + β² I
//   x̂  = x̂⁻ + K (y − λ̄ x̂⁻),  K = λ̄ P⁻ S⁻¹,  λ̄ = 1 − p       it knows how often measurements are lost, not which
//   S  = λ̄² P⁻ + λ̄ (1 − λ̄) E[x xᵀ] + R,   E[x xᵀ] ≤ (1 + ε) P⁻ + (1 + 1/ε) x̂⁻ x̂⁻ᵀ,   P = P⁻ − K S Kᵀ
//
// Ranges and bearings are not linear in x: y is the node's position as the packets of the anchors have it, a_k − d u, averaged with
// the covariance R that σ and κ give them, and λ is that of the first anchor's packet. ε = 1. Starts at the first fix.
// S grows with ‖x̂‖²: the error depends on where the origin is, and that is what paper C's 20 m to 50 m are.
#pragma once

#include <holdfast/benchmarks/papers/network_graph.hpp>

namespace holdfast::bench {

template <int S>
Tracks<S> variance_constrained(const Network<S>& network);

}  // namespace holdfast::bench
