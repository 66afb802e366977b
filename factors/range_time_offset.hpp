// A measured distance whose time stamp is not that of the state: it was taken at t + τ, the state is that of t. τ [s] is a Scalar that is
// estimated, one for each sensor: give it a prior. With the agent's velocity it moves the end a:
//
//   RangeWithTimeOffset         r = (‖q_b − q_a‖ − distance) / sigma,  q_a = p + v τ + ½ a τ²      a: a Motion or Accel, v and a its own
//   AntennaRangeWithTimeOffset  the same,                              q_a = p_a + R_a (l_a + u τ)  a: a pose
//
// u [m/s] is the velocity of the antenna in the body frame of a, as odometry and gyroscope have it at t: v + ω × l_a. Both are exact to
// the first order in τ (Accel: to the second): the rest is ½ ‖acceleration‖ τ², 0.5 mm at 0.1 g and 30 ms. b stands still (an anchor), or
// its state is already that of t + τ; its antenna is at q_b = p_b + R_b l_b (antenna_range.hpp). Where a does not move, or only at right
// angles to its ranges, τ cannot be told: check() says so. The model is that of temporal calibration of cameras (Qin and Shen, IROS 2018,
// eq. 5) with a range in place of a feature.
// Where both ends coincide (below kZeroDistance) the residual is its value at 0 and the Jacobian is zero.
#pragma once

#include <holdfast/factors/detail/antenna.hpp>
#include <holdfast/factors/detail/transition.hpp>

namespace holdfast {

template <class M, class B>
struct RangeWithTimeOffset {
  static_assert(M::order > 1, "the first variable has a velocity: Motion2, Accel2, Motion3 or Accel3");
  double distance;  ///< [m]
  double sigma;     ///< [m]

  using Variables = variables<M, B, Scalar>;
  static constexpr int residual_dim = 1;
  static const char* name() { return "RangeWithTimeOffset"; }
  static constexpr auto fields() {
    return std::tuple(field("distance", &RangeWithTimeOffset::distance), field("sigma", &RangeWithTimeOffset::sigma));
  }

  Vector<1> operator()(const M& a, const B& b, const Scalar& offset, Jacobians<RangeWithTimeOffset>* J = nullptr) const {
    constexpr int N = space_dim<M>;
    const double tau = offset.value;
    const typename M::Tangent then = predicted(a, tau);
    const M moved(then);
    const SafeNorm<N> norm = safe_norm<N>(b.position() - moved.position());
    if (J != nullptr) {
      const Matrix<1, N> u = norm.gradient.transpose() / sigma;
      J->template wrt<0>().setZero();
      double power = 1;  // τ^k / k!
      for (int k = 0; k < M::order; power *= tau / ++k)
        for (int axis = 0; axis < N; ++axis) J->all(0, axis * M::order + k) = -power * u[axis];
      detail::carry_to_tangent<1, N, B::dim>(u, B::position_jacobian(), 1, J->all.data() + M::dim);
      J->all(0, M::dim + B::dim) = -u.dot(moved.derivative(1).transpose());
    }
    return Vector<1>((norm.value - distance) / sigma);
  }

  Vector<1> raw(const Vector<1>& r) const { return sigma * r; }  ///< [m]
  void validate() const {
    require_not_negative("RangeWithTimeOffset.distance", distance);
    require_positive("RangeWithTimeOffset.sigma", sigma);
  }
};

template <class P, class B>
struct AntennaRangeWithTimeOffset {
  static_assert(is_pose<P>, "the first variable is the pose whose antenna moves");
  using Lever = Vector<space_dim<P>>;
  double distance;  ///< [m]
  double sigma;     ///< [m]
  Lever lever_a;    ///< of the antenna in the body frame of a [m]
  Lever lever_b;    ///< of the antenna in the body frame of b [m]
  Lever velocity;   ///< of the antenna of a in the body frame of a [m/s]

  using Variables = variables<P, B, Scalar>;
  static constexpr int residual_dim = 1;
  static const char* name() { return "AntennaRangeWithTimeOffset"; }
  static constexpr auto fields() {
    using F = AntennaRangeWithTimeOffset;
    return std::tuple(field("distance", &F::distance), field("sigma", &F::sigma), field("lever_a", &F::lever_a),
                      field("lever_b", &F::lever_b), field("velocity", &F::velocity));
  }

  Vector<1> operator()(const P& a, const B& b, const Scalar& offset, Jacobians<AntennaRangeWithTimeOffset>* J = nullptr) const {
    constexpr int N = space_dim<P>;
    const detail::Antenna<P> from(a, lever_a + offset.value * velocity);
    const detail::Antenna<B> to(b, lever_b);
    const SafeNorm<N> norm = safe_norm<N>(to.position - from.position);
    if (J != nullptr) {
      const Matrix<1, N> u = norm.gradient.transpose() / sigma;
      detail::carry_to_tangent<1, N, P::dim>(u, from.jacobian, -1, J->all.data());
      detail::carry_to_tangent<1, N, B::dim>(u, to.jacobian, 1, J->all.data() + P::dim);
      J->all(0, P::dim + B::dim) = -u * a.to_world(velocity);
    }
    return Vector<1>((norm.value - distance) / sigma);
  }

  Vector<1> raw(const Vector<1>& r) const { return sigma * r; }  ///< [m]
  void validate() const {
    require_not_negative("AntennaRangeWithTimeOffset.distance", distance);
    require_positive("AntennaRangeWithTimeOffset.sigma", sigma);
    detail::require_lever<P>("AntennaRangeWithTimeOffset.lever_a", lever_a);
    detail::require_lever<B>("AntennaRangeWithTimeOffset.lever_b", lever_b);
    require_finite("AntennaRangeWithTimeOffset.velocity", velocity);
  }
};

}  // namespace holdfast
