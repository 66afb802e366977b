// A landmark (or another agent) measured in the body frame of a pose:   r = W (R_aᵀ (p_l − p_a) − measured)
//
// P: Pose2 or Pose3 (variable 0); L: anything with a position (variable 1). measured [m] and W (space × space, Wᵀ W =
// information) are in the body frame of a. g2o: EDGE_SE2_XY.
#pragma once

#include <holdfast/factors/detail/body_frame.hpp>
#include <holdfast/factors/detail/displacement.hpp>
#include <holdfast/factors/whitening.hpp>
#include <holdfast/graph/batch.hpp>
#include <holdfast/graph/variables.hpp>

namespace holdfast {

template <class P, class L>
struct RelativePoint {
  static_assert(is_pose<P>, "the first variable is the pose in whose body frame the point was measured");
  static constexpr int residual_dim = P::space_dim;
  using Position = Vector<residual_dim>;
  using Square = Matrix<residual_dim, residual_dim>;
  Position measured;  ///< p_body [m]
  Square sqrt_information;

  using Variables = variables<P, L>;
  static const char* name() { return "RelativePoint"; }
  static constexpr auto fields() {
    return std::tuple(field("measured", &RelativePoint::measured), field("sqrt_information", &RelativePoint::sqrt_information));
  }

  static RelativePoint from_sigmas(const Position& measured, const Position& sigmas) {
    return {measured, sqrt_information_from_sigmas<residual_dim>(sigmas)};
  }
  static RelativePoint from_covariance(const Position& measured, const Square& covariance) {
    return {measured, sqrt_information_from_covariance<residual_dim>(covariance)};
  }
  static RelativePoint from_information(const Position& measured, const Square& information) {
    return {measured, sqrt_information_from_information<residual_dim>(information)};
  }

  Position operator()(const P& a, const L& l, Jacobians<RelativePoint>* J = nullptr) const {
    const Position in_body = a.to_body(displacement(a, l));
    if (J != nullptr) {
      const Square W_body = sqrt_information * a.rotation().transpose();
      set_displacement_jacobian(W_body, *J);
      J->template wrt<0>().template rightCols<rotation_dim<residual_dim>>() = sqrt_information * turning_jacobian(in_body);
    }
    return sqrt_information * (in_body - measured);
  }

  void validate() const {
    require_finite("RelativePoint.measured", measured);
    require_finite("RelativePoint.sqrt_information", sqrt_information);
  }
};

// Compiled into the library (factors/compiled.cpp), not anew by whoever adds them to a graph.
extern template class Batch<RelativePoint<Pose2, Point2>>;
extern template class Batch<RelativePoint<Pose3, Point3>>;

}  // namespace holdfast
