// A measured distance whose lever arm is not known, either (antenna_range.hpp has those that are):
//
//   AntennaRangeWithLever   r = (‖q_b − q_a‖ + bias − distance) / sigma,  q_a = p_a + R_a lever,  q_b = p_b
//
// lever [m], a Point2 or Point3 that is estimated, is where the antenna is in the body frame of a: one for each antenna, with a prior (its
// place by a ruler). bias [m] is a Scalar, as in AntennaRangeWithBias. The lever arm is seen where the robot turns while something else
// (odometry, an IMU) says how; without turns check() names what cannot be told apart.
// Where antenna and b coincide (below kZeroDistance) the residual is its value at 0 and the Jacobian by poses and lever is zero.
#pragma once

#include <holdfast/factors/detail/antenna.hpp>

namespace holdfast {

template <class P, class B>
struct AntennaRangeWithLever {
  static_assert(is_pose<P>, "the first variable is the pose in whose body frame the antenna is");
  using Lever = std::conditional_t<space_dim<P> == 2, Point2, Point3>;
  double distance;  ///< [m]
  double sigma;     ///< [m]

  using Variables = variables<P, B, Lever, Scalar>;
  static constexpr int residual_dim = 1;
  static const char* name() { return "AntennaRangeWithLever"; }
  static constexpr auto fields() {
    return std::tuple(field("distance", &AntennaRangeWithLever::distance), field("sigma", &AntennaRangeWithLever::sigma));
  }

  Vector<1> operator()(const P& a, const B& b, const Lever& lever, const Scalar& bias,
                       Jacobians<AntennaRangeWithLever>* J = nullptr) const {
    constexpr int N = space_dim<P>;
    const detail::Antenna<P> from(a, lever.value);
    const SafeNorm<N> norm = safe_norm<N>(b.position() - from.position);
    if (J != nullptr) {
      const Matrix<1, N> u = norm.gradient.transpose() / sigma;
      detail::carry_to_tangent<1, N, P::dim>(u, from.jacobian, -1, J->all.data());
      detail::carry_to_tangent<1, N, B::dim>(u, B::position_jacobian(), 1, J->all.data() + P::dim);
      J->template wrt<2>() = -u * a.rotation();
      J->all(0, P::dim + B::dim + N) = 1 / sigma;
    }
    return Vector<1>((norm.value + bias.value - distance) / sigma);
  }

  Vector<1> raw(const Vector<1>& r) const { return sigma * r; }  ///< [m]
  void validate() const {
    require_not_negative("AntennaRangeWithLever.distance", distance);
    require_positive("AntennaRangeWithLever.sigma", sigma);
  }
};

}  // namespace holdfast
