// A measured difference of distances (TDoA): the antenna of a hears anchors b and c, which send at known times, or b and c hear a:
//
//   TimeDifference            r = (‖q_c − q_a‖ − ‖q_b − q_a‖ − difference) / sigma
//   TimeDifferenceWithOffset  r = (‖q_c − q_a‖ − ‖q_b − q_a‖ + offset − difference) / sigma
//
// difference [m] is c (t_c − t_b), the speed of the signal times how much later the one from c came, corrected for when they were sent; it
// may be negative. offset [m], a Scalar that is estimated, is c times how far the clock of c is ahead of that of b: one for each pair of
// anchors, with a prior. q = p + R l is where an antenna is: l [m], its lever arm, in the body frame; a point has none (antenna_range.hpp).
// A place of constant r is a hyperbola with the foci b and c (Foy, "Position-location solutions by Taylor-series estimation", IEEE
// T-AES 12, 1976). Differences against one common anchor share its noise: they are taken as independent here; pairs that share no anchor
// are. Where a coincides with an anchor (below kZeroDistance) that distance is 0 and says nothing in the Jacobian.
#pragma once

#include <holdfast/factors/detail/antenna.hpp>

namespace holdfast {

namespace detail {

/// ‖q_c − q_a‖ − ‖q_b − q_a‖, and unless J is null its derivative by the tangents of a, b and c side by side.
template <class A, class B, class C>
double distance_difference(const A& a, const Vector<space_dim<A>>& lever_a, const B& b, const C& c,
                           Matrix<1, A::dim + B::dim + C::dim>* J) {
  constexpr int N = space_dim<A>;
  const Antenna<A> heard(a, lever_a);
  const SafeNorm<N> to_b = safe_norm<N>(b.position() - heard.position), to_c = safe_norm<N>(c.position() - heard.position);
  if (J != nullptr) {
    carry_to_tangent<1, N, A::dim>((to_c.gradient - to_b.gradient).transpose(), heard.jacobian, -1, J->data());
    carry_to_tangent<1, N, B::dim>(to_b.gradient.transpose(), B::position_jacobian(), -1, J->data() + A::dim);
    carry_to_tangent<1, N, C::dim>(to_c.gradient.transpose(), C::position_jacobian(), 1, J->data() + A::dim + B::dim);
  }
  return to_c.value - to_b.value;
}

}  // namespace detail

template <class A, class B, class C>
struct TimeDifference {
  using Lever = Vector<space_dim<A>>;
  double difference;  ///< [m]
  double sigma;       ///< [m]
  Lever lever_a;      ///< of the antenna in the body frame of a [m]

  using Variables = variables<A, B, C>;
  static constexpr int residual_dim = 1;
  static const char* name() { return "TimeDifference"; }
  static constexpr auto fields() {
    return std::tuple(field("difference", &TimeDifference::difference), field("sigma", &TimeDifference::sigma),
                      field("lever_a", &TimeDifference::lever_a));
  }

  Vector<1> operator()(const A& a, const B& b, const C& c, Jacobians<TimeDifference>* J = nullptr) const {
    Matrix<1, Variables::total_dim> D;
    const double difference_now = detail::distance_difference(a, lever_a, b, c, J == nullptr ? nullptr : &D);
    if (J != nullptr) J->all = D / sigma;
    return Vector<1>((difference_now - difference) / sigma);
  }

  Vector<1> raw(const Vector<1>& r) const { return sigma * r; }  ///< [m]
  void validate() const {
    require_finite("TimeDifference.difference", difference);
    require_positive("TimeDifference.sigma", sigma);
    detail::require_lever<A>("TimeDifference.lever_a", lever_a);
  }
};

template <class A, class B, class C>
struct TimeDifferenceWithOffset {
  using Lever = Vector<space_dim<A>>;
  double difference;  ///< [m]
  double sigma;       ///< [m]
  Lever lever_a;      ///< of the antenna in the body frame of a [m]

  using Variables = variables<A, B, C, Scalar>;
  static constexpr int residual_dim = 1;
  static const char* name() { return "TimeDifferenceWithOffset"; }
  static constexpr auto fields() {
    using F = TimeDifferenceWithOffset;
    return std::tuple(field("difference", &F::difference), field("sigma", &F::sigma), field("lever_a", &F::lever_a));
  }

  Vector<1> operator()(const A& a, const B& b, const C& c, const Scalar& offset, Jacobians<TimeDifferenceWithOffset>* J = nullptr) const {
    Matrix<1, A::dim + B::dim + C::dim> D;
    const double difference_now = detail::distance_difference(a, lever_a, b, c, J == nullptr ? nullptr : &D);
    if (J != nullptr) J->all << D / sigma, 1 / sigma;
    return Vector<1>((difference_now + offset.value - difference) / sigma);
  }

  Vector<1> raw(const Vector<1>& r) const { return sigma * r; }  ///< [m]
  void validate() const { TimeDifference<A, B, C>{difference, sigma, lever_a}.validate(); }
};

}  // namespace holdfast
