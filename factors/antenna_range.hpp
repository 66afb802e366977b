// A measured distance between two antennas, as UWB radios give it:
//
//   AntennaRange            r = (‖q_b − q_a‖ − distance) / sigma
//   AntennaRangeWithBias    r = (‖q_b − q_a‖ + bias − distance) / sigma       bias: a Scalar [m], of a radio, a pair, or an anchor
//
// q_a = p_a + R_a l_a is where the antenna of a is: l_a [m], its lever arm, in the body frame of a (the same for b). A point has no body
// frame: its lever arm is 0. The bias is what the radios' delays add to every distance; estimate one for each anchor, with a prior. Without
// turns of the robot, or with one anchor alone, bias and distance cannot be told apart: check() says so.
// Where both antennas coincide (below kZeroDistance) the residual is its value at 0 and the Jacobian by the poses is zero.
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

template <class A, class B>
struct AntennaRange {
  using Lever = Vector<space_dim<A>>;
  double distance;  ///< [m]
  double sigma;     ///< [m]
  Lever lever_a;    ///< of the antenna in the body frame of a [m]
  Lever lever_b;    ///< of the antenna in the body frame of b [m]

  using Variables = variables<A, B>;
  static constexpr int residual_dim = 1;
  static const char* name() { return "AntennaRange"; }
  static constexpr auto fields() {
    return std::tuple(field("distance", &AntennaRange::distance), field("sigma", &AntennaRange::sigma),
                      field("lever_a", &AntennaRange::lever_a), field("lever_b", &AntennaRange::lever_b));
  }

  Vector<1> operator()(const A& a, const B& b, Jacobians<AntennaRange>* J = nullptr) const {
    Matrix<1, Variables::total_dim> D;
    const double measured = detail::antenna_distance(a, lever_a, b, lever_b, J == nullptr ? nullptr : &D);
    if (J != nullptr) J->all = D / sigma;
    return Vector<1>((measured - distance) / sigma);
  }

  Vector<1> raw(const Vector<1>& r) const { return sigma * r; }  ///< [m]
  void validate() const {
    require_not_negative("AntennaRange.distance", distance);
    require_positive("AntennaRange.sigma", sigma);
    detail::require_lever<A>("AntennaRange.lever_a", lever_a);
    detail::require_lever<B>("AntennaRange.lever_b", lever_b);
  }
};

template <class A, class B>
struct AntennaRangeWithBias {
  using Lever = Vector<space_dim<A>>;
  double distance;  ///< [m]
  double sigma;     ///< [m]
  Lever lever_a;    ///< of the antenna in the body frame of a [m]
  Lever lever_b;    ///< of the antenna in the body frame of b [m]

  using Variables = variables<A, B, Scalar>;
  static constexpr int residual_dim = 1;
  static const char* name() { return "AntennaRangeWithBias"; }
  static constexpr auto fields() {
    return std::tuple(field("distance", &AntennaRangeWithBias::distance), field("sigma", &AntennaRangeWithBias::sigma),
                      field("lever_a", &AntennaRangeWithBias::lever_a), field("lever_b", &AntennaRangeWithBias::lever_b));
  }

  Vector<1> operator()(const A& a, const B& b, const Scalar& bias, Jacobians<AntennaRangeWithBias>* J = nullptr) const {
    Matrix<1, A::dim + B::dim> D;
    const double measured = detail::antenna_distance(a, lever_a, b, lever_b, J == nullptr ? nullptr : &D);
    if (J != nullptr) J->all << D / sigma, 1 / sigma;
    return Vector<1>((measured + bias.value - distance) / sigma);
  }

  Vector<1> raw(const Vector<1>& r) const { return sigma * r; }  ///< [m]
  void validate() const { AntennaRange<A, B>{distance, sigma, lever_a, lever_b}.validate(); }
};

}  // namespace holdfast
