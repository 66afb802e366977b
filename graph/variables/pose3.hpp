// Pose in space: T_world_body = (p, R), R ∈ SO(3) kept as a unit quaternion (x y z w). Tangent [δp_world (m), δφ_body (rad)].
#pragma once

#include <holdfast/graph/manifold.hpp>
#include <holdfast/graph/variables/kinematic.hpp>
#include <holdfast/graph/variables/so3.hpp>

namespace holdfast {

template <class T>
struct Pose3T {
  static constexpr int dim = 6;
  static constexpr int space_dim = 3;
  using Tangent = VectorT<T, 6>;
  using Rotation = so3::Quaternion<T>;
  template <class U>
  using rebind = Pose3T<U>;

  VectorT<T, 3> p{T(0), T(0), T(0)};   ///< p_world [m]
  Rotation q{T(1), T(0), T(0), T(0)};  ///< unit quaternion of R_world_body

  Pose3T() = default;
  Pose3T(const VectorT<T, 3>& position, const Rotation& rotation) : p(position), q(rotation) {}

  /// R = R_z(yaw) R_y(pitch) R_x(roll) [rad]: turned about the world's x axis first, then y, then z.
  static Pose3T from_roll_pitch_yaw(const VectorT<T, 3>& position, T roll, T pitch, T yaw) {
    return {position, so3::from_roll_pitch_yaw<T>({roll, pitch, yaw})};
  }
  /// (roll, pitch, yaw) [rad] with pitch in [−π/2, π/2]. At pitch ±π/2 roll and yaw turn about the same axis: only together are they right.
  VectorT<T, 3> roll_pitch_yaw() const { return so3::roll_pitch_yaw<T>(rotation()); }

  static const char* name() { return "Pose3"; }
  template <class U>
  rebind<U> cast() const {
    return {p.template cast<U>().eval(), so3::Quaternion<U>(q.coeffs().template cast<U>().eval())};
  }

  MatrixT<T, 3, 3> rotation() const { return q.toRotationMatrix(); }
  VectorT<T, 3> to_world(const VectorT<T, 3>& v) const { return q * v; }
  VectorT<T, 3> to_body(const VectorT<T, 3>& v) const { return q.conjugate() * v; }
  /// T_world_body · T_body_other.
  Pose3T operator*(const Pose3T& other) const { return {(p + to_world(other.p)).eval(), q * other.q}; }
  /// A point of the body frame in the world frame: p + R v.
  VectorT<T, 3> operator*(const VectorT<T, 3>& v) const { return p + to_world(v); }
  template <int Axes>
  Kinematic<T, Axes, 1> operator*(const Kinematic<T, Axes, 1>& point) const {
    static_assert(Axes == 3, "a pose in space moves points in space");
    return Kinematic<T, Axes, 1>(p + to_world(point.value));
  }
  Pose3T inverse() const { return {(-to_body(p)).eval(), q.conjugate()}; }

  Pose3T retract(const Tangent& delta) const {
    Rotation turned = q * so3::exp<T>(delta.template tail<3>());
    turned.coeffs() *= (T(3) - turned.squaredNorm()) / T(2);  // one Newton step to unit length
    return {(p + delta.template head<3>()).eval(), turned};
  }
  Tangent local(const Pose3T& other) const {
    Tangent delta;
    delta.template head<3>() = other.p - p;
    delta.template tail<3>() = so3::log<T>(q.conjugate() * other.q);
    return delta;
  }
  /// The rotation's is J_r⁻¹ (Solà et al., "A micro Lie theory", 144).
  Matrix<6, 6> local_jacobian(const Pose3T& other) const {
    Matrix<6, 6> J = Matrix<6, 6>::Identity();
    J.template bottomRightCorner<3, 3>() = so3::right_jacobian_inverse(so3::log<T>(q.conjugate() * other.q));
    return J;
  }
  bool is_finite() const { return p.array().isFinite().all() && q.coeffs().array().isFinite().all(); }

  VectorT<T, 3> position() const { return p; }
  static Matrix<3, 6> position_jacobian() { return Matrix<3, 6>::Identity(); }
  Tangent rigid_motion(const VectorT<T, 3>& v, const VectorT<T, 3>& w) const {
    Tangent motion;
    motion.template head<3>() = v + cross<T>(w, p);
    motion.template tail<3>() = to_body(w);
    return motion;
  }
};
using Pose3 = Pose3T<double>;

}  // namespace holdfast
