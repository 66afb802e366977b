// Antennas on bodies: where they are, how far apart, and the chain rule to the tangents.
#pragma once

#include <holdfast/factors/detail/body_frame.hpp>
#include <holdfast/factors/detail/displacement.hpp>
#include <holdfast/graph/require.hpp>
#include <holdfast/graph/variables.hpp>

namespace holdfast {

namespace detail {

/// Where the antenna of x is, and its derivative by the tangent of x.
template <class V>
struct Antenna {
  Vector<space_dim<V>> position;
  Matrix<space_dim<V>, V::dim> jacobian;

  Antenna(const V& x, const Vector<space_dim<V>>& lever) : position(x.position()), jacobian(V::position_jacobian()) {
    if constexpr (is_pose<V>) {
      const auto R = x.rotation();
      position += R * lever;
      jacobian.template rightCols<rotation_dim<space_dim<V>>>() = -R * turning_jacobian(lever);  // R Exp(δ) l = R l − R (l × δ)
    }
  }
};

/// ‖q_b − q_a‖, and unless J is null its derivative by the tangents of a and b side by side.
template <class A, class B>
double antenna_distance(const A& a, const Vector<space_dim<A>>& lever_a, const B& b, const Vector<space_dim<A>>& lever_b,
                        Matrix<1, A::dim + B::dim>* J) {
  const Antenna<A> from(a, lever_a);
  const Antenna<B> to(b, lever_b);
  const SafeNorm<space_dim<A>> norm = safe_norm<space_dim<A>>(to.position - from.position);
  if (J != nullptr) {
    const Matrix<1, space_dim<A>> u = norm.gradient.transpose();
    carry_to_tangent<1, space_dim<A>, A::dim>(u, from.jacobian, -1, J->data());
    carry_to_tangent<1, space_dim<A>, B::dim>(u, to.jacobian, 1, J->data() + A::dim);
  }
  return norm.value;
}

template <class V>
void require_lever(const char* name, const Vector<space_dim<V>>& lever) {
  require_finite(name, lever);
  if (!is_pose<V> && !lever.isZero(0)) fail<BadNumber>(name, " = (", lever.transpose(), "): a ", V::name(), " has no body frame; give 0");
}

}  // namespace detail

}  // namespace holdfast
