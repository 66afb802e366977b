// A measured direction u (unit vector) from a to b with concentration κ, von Mises (2D) or von Mises–Fisher (3D). With the true
// direction e = (p_b − p_a)/‖p_b − p_a‖
//
//   VonMisesBearing      r = √κ (u − e)         u in the world frame          (paper C, eq. 3: ½‖r‖² = κ − κ uᵀe exactly)
//   VonMisesBearingBody  r = √κ (u − R_aᵀ e)    u in the body frame of pose a
//
// so least squares is the von Mises–Fisher likelihood. For small errors κ = 1/σ² with σ [rad] per direction. A and B: anything
// with a position. Where both positions coincide (below kZeroDistance) residual and Jacobian are zero.
#pragma once

#include <holdfast/factors/bearing_ray.hpp>
#include <holdfast/factors/detail/body_frame.hpp>
#include <holdfast/factors/detail/displacement.hpp>
#include <holdfast/factors/detail/rules.hpp>
#include <holdfast/graph/batch.hpp>
#include <holdfast/graph/variables.hpp>

namespace holdfast {

namespace detail {
/// d (x/‖x‖) / d x.
template <int N>
Matrix<N, N> direction_jacobian(const SafeNorm<N>& norm) {
  return (Matrix<N, N>::Identity() - norm.gradient * norm.gradient.transpose()) / norm.value;
}
}  // namespace detail

template <class A, class B>
struct VonMisesBearing {
  static constexpr int residual_dim = space_dim<A>;
  using Direction = Vector<residual_dim>;
  Direction direction;  ///< unit vector from a to b, world frame
  double kappa;         ///< concentration [1]

  using Variables = variables<A, B>;
  static const char* name() { return "VonMisesBearing"; }
  static constexpr auto fields() {
    return std::tuple(field("direction", &VonMisesBearing::direction), field("kappa", &VonMisesBearing::kappa));
  }

  Direction operator()(const A& a, const B& b, Jacobians<VonMisesBearing>* J = nullptr) const {
    const auto norm = safe_norm(displacement(a, b));
    if (norm.value == 0) {
      if (J != nullptr) J->all.setZero();
      return Direction::Zero();
    }
    const double root = std::sqrt(kappa);
    if (J != nullptr) set_displacement_jacobian(-root * detail::direction_jacobian(norm), *J);
    return root * (direction - norm.gradient);
  }

  /// As wide as the bearing is at one metre: the edge says nothing of its length.
  BearingRay<A, B> relaxed() const { return {direction, 1 / std::sqrt(kappa)}; }

  void validate() const {
    require_unit("VonMisesBearing.direction", direction);
    require_concentration("VonMisesBearing.kappa", kappa);
  }
};

template <class P, class B>
struct VonMisesBearingBody {
  static_assert(is_pose<P>, "the first variable is the pose in whose body frame the direction was measured");
  static constexpr int residual_dim = space_dim<P>;
  using Direction = Vector<residual_dim>;
  Direction direction;  ///< unit vector from a to b, body frame of a
  double kappa;         ///< concentration [1]

  using Variables = variables<P, B>;
  static const char* name() { return "VonMisesBearingBody"; }
  static constexpr auto fields() {
    return std::tuple(field("direction", &VonMisesBearingBody::direction), field("kappa", &VonMisesBearingBody::kappa));
  }

  Direction operator()(const P& a, const B& b, Jacobians<VonMisesBearingBody>* J = nullptr) const {
    const auto norm = safe_norm(displacement(a, b));
    if (norm.value == 0) {
      if (J != nullptr) J->all.setZero();
      return Direction::Zero();
    }
    const double root = std::sqrt(kappa);
    const Direction in_body = a.to_body(norm.gradient);
    if (J != nullptr) {
      set_displacement_jacobian(-root * (a.rotation().transpose() * detail::direction_jacobian(norm)), *J);
      J->template wrt<0>().template rightCols<rotation_dim<residual_dim>>() = -root * turning_jacobian(in_body);
    }
    return root * (direction - in_body);
  }

  void validate() const {
    require_unit("VonMisesBearingBody.direction", direction);
    require_concentration("VonMisesBearingBody.kappa", kappa);
  }
};

// Compiled into the library (factors/compiled.cpp), not anew by whoever adds them to a graph.
extern template class Batch<VonMisesBearingBody<Pose2, Point2>>;
extern template class Batch<VonMisesBearingBody<Pose3, Point3>>;

}  // namespace holdfast
