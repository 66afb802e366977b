// Prior on one variable:   r = W (x ⊖ mean),   W dim × dim with Wᵀ W = information.
//
// The units are those of the variable's tangent (translation in the world frame [m], then rotation in the body frame [rad]).
// For Pose3 the rotation part is Log(R_meanᵀ R), the full angle; its Jacobian is J_r⁻¹ (Solà et al., "A micro Lie theory", 144).
// A variable type of your own: its local_jacobian(), or, without one, dual numbers (graph/manifold.hpp).
// An information may be semidefinite (whitening.hpp): a GPS position is a prior on a pose that says nothing of the rotation.
#pragma once

#include <holdfast/factors/detail/body_frame.hpp>
#include <holdfast/factors/detail/vector_space.hpp>
#include <holdfast/factors/whitening.hpp>
#include <holdfast/graph/batch.hpp>
#include <holdfast/graph/detail/local_jacobian.hpp>
#include <holdfast/graph/variables.hpp>

namespace holdfast {

template <class V>
struct Prior {
  using Square = Matrix<V::dim, V::dim>;
  V mean;
  Square sqrt_information;

  using Variables = variables<V>;
  static constexpr int residual_dim = V::dim;
  static constexpr bool is_linear = is_vector_space<V>;
  static const char* name() { return "Prior"; }
  static constexpr auto fields() { return std::tuple(field("mean", &Prior::mean), field("sqrt_information", &Prior::sqrt_information)); }

  static Prior from_sigmas(const V& mean, const Vector<V::dim>& sigmas) { return {mean, sqrt_information_from_sigmas<V::dim>(sigmas)}; }
  static Prior from_covariance(const V& mean, const Square& covariance) {
    return {mean, sqrt_information_from_covariance<V::dim>(covariance)};
  }
  static Prior from_information(const V& mean, const Square& information) {
    return {mean, sqrt_information_from_information<V::dim>(information)};
  }

  Vector<V::dim> operator()(const V& x, Jacobians<Prior>* J = nullptr) const {
    const Vector<V::dim> error = mean.local(x);
    if (J != nullptr) {
      J->all = sqrt_information;
      if constexpr (!is_vector_space<V> && !is_pose<V>)
        J->all = sqrt_information * local_jacobian(mean, x);
      else if constexpr (std::is_same_v<V, Pose3>)
        J->all.template rightCols<3>() = sqrt_information.template rightCols<3>() * so3::right_jacobian_inverse(error.template tail<3>());
    }
    return sqrt_information * error;
  }

  void validate() const {
    if (!mean.is_finite()) fail<BadNumber>("Prior.mean is not finite; give the ", V::name(), " the variable is expected at");
    require_finite("Prior.sqrt_information", sqrt_information);
  }
};

// Compiled into the library (factors/compiled.cpp), not anew by whoever adds them to a graph.
extern template class Batch<Prior<Point2>>;
extern template class Batch<Prior<Point3>>;
extern template class Batch<Prior<Pose2>>;
extern template class Batch<Prior<Pose3>>;
extern template class Batch<Prior<Motion2>>;
extern template class Batch<Prior<Motion3>>;
extern template class Batch<Prior<Accel3>>;

}  // namespace holdfast
