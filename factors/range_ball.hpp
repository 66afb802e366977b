// The convex relaxation of a range: a distance is an upper bound.   r = max(0, ‖p_a − p_b‖ − distance) / sigma
//
// Paper C (4)–(6): ½ r² is the least ½ ‖p_a − p_b − y‖²/σ² over the ball ‖y‖ ≤ distance, i.e. the squared distance to the ball.
// A and B: anything with a position. Inside the ball, and where both positions coincide, residual and Jacobian are zero.
#pragma once

#include <holdfast/factors/displacement.hpp>
#include <holdfast/graph/require.hpp>

namespace holdfast {

template <class A, class B>
struct RangeBall {
  double distance;  ///< [m]
  double sigma;     ///< [m]

  using Variables = variables<A, B>;
  static constexpr int residual_dim = 1;
  static constexpr bool is_convex = true;  // for poses, too: the position is linear in every tangent
  static const char* name() { return "RangeBall"; }

  Vector<1> operator()(const A& a, const B& b, Jacobians<RangeBall>* J = nullptr) const {
    const auto norm = safe_norm(displacement(a, b));
    const bool inside = norm.value <= distance;  // false for NaN, which so reaches the residual
    if (J != nullptr) set_displacement_jacobian((inside ? 0 : 1 / sigma) * norm.gradient.transpose(), *J);
    return Vector<1>(inside ? 0 : (norm.value - distance) / sigma);
  }

  Vector<1> raw(const Vector<1>& r) const { return sigma * r; }  ///< [m]
  void validate() const {
    require_not_negative("RangeBall.distance", distance);
    require_positive("RangeBall.sigma", sigma);
  }
};

}  // namespace holdfast
