// The convex counterpart of a direction without a range: b lies on the ray from a along the direction.
//
//   r = (x − y) / sigma,   x = p_b − p_a,   y = max(0, uᵀx) u its nearest point on the ray
//
// ½‖r‖² is the squared distance to a convex set. Unlike the bearing's own cost it grows with the distance, so that without other
// factors everything would shrink to one point; sigma [m] is the bearing's error across the ray, its angle times a typical distance.
// Components are along the axes of the world: give it block losses. A and B: anything with a position.
#pragma once

#include <holdfast/factors/detail/displacement.hpp>
#include <holdfast/factors/detail/rules.hpp>

namespace holdfast {

template <class A, class B>
struct BearingRay {
  static constexpr int residual_dim = space_dim<A>;
  using Direction = Vector<residual_dim>;
  Direction direction;  ///< unit vector from a to b, world frame
  double sigma;         ///< [m]

  using Variables = variables<A, B>;
  static constexpr bool is_convex = true;
  static const char* name() { return "BearingRay"; }
  static constexpr auto fields() { return std::tuple(field("direction", &BearingRay::direction), field("sigma", &BearingRay::sigma)); }

  Direction operator()(const A& a, const B& b, Jacobians<BearingRay>* J = nullptr) const {
    using Square = Matrix<residual_dim, residual_dim>;
    const Direction x = displacement(a, b);
    const bool behind = direction.dot(x) < 0;
    const Square to_ray = behind ? Square(Square::Identity()) : Square(Square::Identity() - direction * direction.transpose());
    if (J != nullptr) set_displacement_jacobian(to_ray / sigma, *J);
    return to_ray * x / sigma;
  }
  Direction raw(const Direction& r) const { return sigma * r; }  ///< [m]

  void validate() const {
    require_unit("BearingRay.direction", direction);
    require_positive("BearingRay.sigma", sigma);
  }
};

}  // namespace holdfast
