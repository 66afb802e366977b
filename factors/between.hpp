// Relative measurement between two variables of one type, W dim × dim with Wᵀ W = information.
//
//   poses:          r = W [ R_zᵀ (R_aᵀ (p_b − p_a) − t_z) ; Log(R_zᵀ R_aᵀ R_b) ]     measured = T_a_b = (t_z, R_z)
//   vector spaces:  r = W (x_b − x_a − measured)
//
// The pose residual is the translation [m] and the full-angle rotation vector [rad] of T_z⁻¹ T_a⁻¹ T_b: the information is in the
// frame of the measured b, translation first (g2o's EDGE_SE2; its EDGE_SE3:QUAT has half angles and is converted by the reader).
// The Jacobians are exact away from the optimum, too, in our tangent (world translation, right rotation).
#pragma once

#include <holdfast/factors/detail/body_frame.hpp>
#include <holdfast/factors/detail/vector_space.hpp>
#include <holdfast/factors/whitening.hpp>
#include <holdfast/graph/batch.hpp>
#include <holdfast/graph/variables.hpp>

namespace holdfast {

template <class V>
struct Between {
  using Square = Matrix<V::dim, V::dim>;
  V measured;
  Square sqrt_information;

  using Variables = variables<V, V>;
  static constexpr int residual_dim = V::dim;
  static constexpr bool is_linear = is_vector_space<V>;
  static const char* name() { return "Between"; }
  static constexpr auto fields() {
    return std::tuple(field("measured", &Between::measured), field("sqrt_information", &Between::sqrt_information));
  }

  static Between from_sigmas(const V& measured, const Vector<V::dim>& sigmas) {
    return {measured, sqrt_information_from_sigmas<V::dim>(sigmas)};
  }
  static Between from_covariance(const V& measured, const Square& covariance) {
    return {measured, sqrt_information_from_covariance<V::dim>(covariance)};
  }
  static Between from_information(const V& measured, const Square& information) {
    return {measured, sqrt_information_from_information<V::dim>(information)};
  }

  Vector<V::dim> operator()(const V& a, const V& b, Jacobians<Between>* J = nullptr) const {
    static_assert(is_vector_space<V> || is_pose<V>, "write the relative measurement of this type as an AutoDiff factor");
    if constexpr (is_vector_space<V>) {
      if (J != nullptr) {
        J->template wrt<0>() = -sqrt_information;
        J->template wrt<1>() = sqrt_information;
      }
      return sqrt_information * (a.local(b) - V{}.local(measured));
    } else {
      return whitened_error(a, b, J);
    }
  }

  template <class P = V, class = std::enable_if_t<is_pose<P>>>
  const P& relative_pose() const {
    return measured;
  }

  void validate() const {
    if (!measured.is_finite()) fail<BadNumber>("Between.measured is not finite; leave the measurement out, or repair its source");
    require_finite("Between.sqrt_information", sqrt_information);
  }

 private:
  Vector<3> whitened_error(const Pose2& a, const Pose2& b, Jacobians<Between>* J) const {
    const Vector<2> b_in_a = a.to_body(b.p - a.p);
    const Vector<2> t = measured.to_body(b_in_a - measured.p);
    const Vector<2> turn = measured.to_body(a.to_body(b.heading));
    if (J != nullptr) {
      const auto Wt = sqrt_information.template leftCols<2>();
      const Vector<2> h = a.to_world(measured.heading);  // heading of R_a R_z
      Matrix<2, 2> from_world;
      from_world << h[0], h[1], -h[1], h[0];
      auto wrt_a = J->template wrt<0>();
      auto wrt_b = J->template wrt<1>();
      wrt_b.template leftCols<2>().noalias() = Wt * from_world;
      wrt_b.col(2) = sqrt_information.col(2);
      wrt_a.template leftCols<2>() = -wrt_b.template leftCols<2>();
      wrt_a.col(2) = Wt * measured.to_body(turning_jacobian(b_in_a)) - sqrt_information.col(2);
    }
    return sqrt_information * Vector<3>(t[0], t[1], std::atan2(turn[1], turn[0]));
  }

  Vector<6> whitened_error(const Pose3& a, const Pose3& b, Jacobians<Between>* J) const {
    const Matrix<3, 3> body_a = a.rotation().transpose();
    const Matrix<3, 3> body_z = measured.rotation().transpose();
    const Vector<3> b_in_a = body_a * (b.p - a.p);
    const so3::Quaternion<double> b_from_a = a.q.conjugate() * b.q;
    Vector<6> error;
    error.head<3>() = body_z * (b_in_a - measured.p);
    error.tail<3>() = so3::log<double>(measured.q.conjugate() * b_from_a);
    if (J != nullptr) {
      const Matrix<6, 3> Wz = sqrt_information.template leftCols<3>() * body_z;
      auto wrt_a = J->template wrt<0>();
      auto wrt_b = J->template wrt<1>();
      wrt_b.template leftCols<3>().noalias() = Wz * body_a;
      wrt_a.template leftCols<3>() = -wrt_b.template leftCols<3>();
      wrt_b.template rightCols<3>().noalias() = sqrt_information.template rightCols<3>() * so3::right_jacobian_inverse(error.tail<3>());
      // R_zᵀ Exp(−δ_a) R_aᵀ R_b = E Exp(−R_bᵀ R_a δ_a)
      wrt_a.template rightCols<3>().noalias() = Wz * turning_jacobian(b_in_a);
      wrt_a.template rightCols<3>().noalias() -= wrt_b.template rightCols<3>() * b_from_a.toRotationMatrix().transpose();
    }
    return sqrt_information * error;
  }
};

// Compiled into the library (factors/compiled.cpp), not anew by whoever adds them to a graph.
extern template class Batch<Between<Pose2>>;
extern template class Batch<Between<Pose3>>;

}  // namespace holdfast
