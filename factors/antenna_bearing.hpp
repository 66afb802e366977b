// A measured direction u (unit vector) between two antennas (an array of them, a camera) with concentration κ, von Mises (2D) or von
// Mises–Fisher (3D). With the true direction e = (q_b − q_a)/‖q_b − q_a‖
//
//   AntennaBearing      r = √κ (u − e)         u in the world frame
//   AntennaBearingBody  r = √κ (u − R_aᵀ e)    u in the body frame of a
//
// as VonMisesBearing and VonMisesBearingBody (von_mises_bearing.hpp), whose source and κ they share, but from antenna to antenna:
// q_a = p_a + R_a l_a with l_a [m], its lever arm, in the body frame of a (the same for b). A point has no body frame: its lever arm is 0.
// A sensor that is turned in the body: give R_body_sensor u. Bearings say nothing of the distance, and near an antenna the lever arm is
// most of the direction: 0.3 m at 2 m are 9 degrees. Where both antennas coincide (below kZeroDistance) residual and Jacobian are zero.
#pragma once

#include <holdfast/factors/detail/antenna.hpp>
#include <holdfast/factors/detail/rules.hpp>

namespace holdfast {

namespace detail {
template <class F>
constexpr auto antenna_bearing_fields() {
  return std::tuple(field("direction", &F::direction), field("kappa", &F::kappa), field("lever_a", &F::lever_a),
                    field("lever_b", &F::lever_b));
}
}  // namespace detail

template <class A, class B>
struct AntennaBearing {
  static constexpr int residual_dim = space_dim<A>;
  using Direction = Vector<residual_dim>;
  Direction direction;  ///< unit vector from the antenna of a to that of b, world frame
  double kappa;         ///< concentration [1]
  Direction lever_a;    ///< of the antenna in the body frame of a [m]
  Direction lever_b;    ///< of the antenna in the body frame of b [m]

  using Variables = variables<A, B>;
  static const char* name() { return "AntennaBearing"; }
  static constexpr auto fields() { return detail::antenna_bearing_fields<AntennaBearing>(); }

  Direction operator()(const A& a, const B& b, Jacobians<AntennaBearing>* J = nullptr) const {
    constexpr int N = residual_dim;
    const detail::Antenna<A> from(a, lever_a);
    const detail::Antenna<B> to(b, lever_b);
    const SafeNorm<N> norm = safe_norm<N>(to.position - from.position);
    if (norm.value == 0) {
      if (J != nullptr) J->all.setZero();
      return Direction::Zero();
    }
    const double root = std::sqrt(kappa);
    if (J != nullptr) {
      const Matrix<N, N> D = -root / norm.value * (Matrix<N, N>::Identity() - norm.gradient * norm.gradient.transpose());
      detail::carry_to_tangent<N, N, A::dim>(D, from.jacobian, -1, J->all.data());
      detail::carry_to_tangent<N, N, B::dim>(D, to.jacobian, 1, J->all.data() + N * A::dim);
    }
    return root * (direction - norm.gradient);
  }

  void validate() const {
    require_unit("AntennaBearing.direction", direction);
    require_concentration("AntennaBearing.kappa", kappa);
    detail::require_lever<A>("AntennaBearing.lever_a", lever_a);
    detail::require_lever<B>("AntennaBearing.lever_b", lever_b);
  }
};

template <class P, class B>
struct AntennaBearingBody {
  static_assert(is_pose<P>, "the first variable is the pose in whose body frame the direction was measured");
  static constexpr int residual_dim = space_dim<P>;
  using Direction = Vector<residual_dim>;
  Direction direction;  ///< unit vector from the antenna of a to that of b, body frame of a
  double kappa;         ///< concentration [1]
  Direction lever_a;    ///< of the antenna in the body frame of a [m]
  Direction lever_b;    ///< of the antenna in the body frame of b [m]

  using Variables = variables<P, B>;
  static const char* name() { return "AntennaBearingBody"; }
  static constexpr auto fields() { return detail::antenna_bearing_fields<AntennaBearingBody>(); }

  Direction operator()(const P& a, const B& b, Jacobians<AntennaBearingBody>* J = nullptr) const {
    constexpr int N = residual_dim;
    const detail::Antenna<P> from(a, lever_a);
    const detail::Antenna<B> to(b, lever_b);
    const SafeNorm<N> norm = safe_norm<N>(to.position - from.position);
    if (norm.value == 0) {
      if (J != nullptr) J->all.setZero();
      return Direction::Zero();
    }
    const double root = std::sqrt(kappa);
    const Direction in_body = a.to_body(norm.gradient);
    if (J != nullptr) {
      const Matrix<N, N> D =
          -root / norm.value * (a.rotation().transpose() * (Matrix<N, N>::Identity() - norm.gradient * norm.gradient.transpose()));
      detail::carry_to_tangent<N, N, P::dim>(D, from.jacobian, -1, J->all.data());
      detail::carry_to_tangent<N, N, B::dim>(D, to.jacobian, 1, J->all.data() + N * P::dim);
      J->template wrt<0>().template rightCols<rotation_dim<N>>() -= root * turning_jacobian(in_body);
    }
    return root * (direction - in_body);
  }

  void validate() const {
    require_unit("AntennaBearingBody.direction", direction);
    require_concentration("AntennaBearingBody.kappa", kappa);
    detail::require_lever<P>("AntennaBearingBody.lever_a", lever_a);
    detail::require_lever<B>("AntennaBearingBody.lever_b", lever_b);
  }
};

}  // namespace holdfast
