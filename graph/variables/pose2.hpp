// Pose in the plane: T_world_body = (p, R), R ∈ SO(2) kept as (cos θ, sin θ): no angle ever needs wrapping, and a factor
// needs no sine. Tangent [δp_world (m), δθ (rad)].
#pragma once

#include <holdfast/graph/variables/kinematic.hpp>

namespace holdfast {

template <class T>
struct Pose2T {
  static constexpr int dim = 3;
  static constexpr int space_dim = 2;
  using Tangent = VectorT<T, 3>;
  template <class U>
  using rebind = Pose2T<U>;

  VectorT<T, 2> p{T(0), T(0)};        ///< p_world [m]
  VectorT<T, 2> heading{T(1), T(0)};  ///< (cos θ, sin θ): the body's x axis in the world

  Pose2T() = default;
  Pose2T(T x, T y, T theta) : p(x, y) {
    using std::cos;
    using std::sin;
    heading = {cos(theta), sin(theta)};
  }
  Pose2T(const VectorT<T, 2>& position, const VectorT<T, 2>& unit_heading) : p(position), heading(unit_heading) {}

  static const char* name() { return "Pose2"; }
  template <class U>
  rebind<U> cast() const {
    return {p.template cast<U>().eval(), heading.template cast<U>().eval()};
  }

  T angle() const {
    using std::atan2;
    return atan2(heading[1], heading[0]);
  }
  MatrixT<T, 2, 2> rotation() const {
    MatrixT<T, 2, 2> R;
    R << heading[0], -heading[1], heading[1], heading[0];
    return R;
  }
  /// A vector of the body frame in the world frame, and back.
  VectorT<T, 2> to_world(const VectorT<T, 2>& v) const {
    return {heading[0] * v[0] - heading[1] * v[1], heading[1] * v[0] + heading[0] * v[1]};
  }
  VectorT<T, 2> to_body(const VectorT<T, 2>& v) const {
    return {heading[0] * v[0] + heading[1] * v[1], heading[0] * v[1] - heading[1] * v[0]};
  }
  /// T_world_body · T_body_other.
  Pose2T operator*(const Pose2T& other) const { return {(p + to_world(other.p)).eval(), to_world(other.heading)}; }
  /// A point of the body frame in the world frame: p + R v.
  VectorT<T, 2> operator*(const VectorT<T, 2>& v) const { return p + to_world(v); }
  template <int Axes>
  Kinematic<T, Axes, 1> operator*(const Kinematic<T, Axes, 1>& point) const {
    static_assert(Axes == 2, "a pose in the plane moves points of the plane");
    return Kinematic<T, Axes, 1>(p + to_world(point.value));
  }
  Pose2T inverse() const { return {(-to_body(p)).eval(), VectorT<T, 2>(heading[0], -heading[1])}; }

  Pose2T retract(const Tangent& delta) const {
    using std::cos;
    using std::sin;
    VectorT<T, 2> turned = to_world(VectorT<T, 2>(cos(delta[2]), sin(delta[2])));
    turned *= (T(3) - turned.squaredNorm()) / T(2);  // one Newton step to unit length: rounding never accumulates
    return {VectorT<T, 2>(p[0] + delta[0], p[1] + delta[1]), turned};
  }
  Tangent local(const Pose2T& other) const {
    using std::atan2;
    const VectorT<T, 2> turn = to_body(other.heading);
    return {other.p[0] - p[0], other.p[1] - p[1], atan2(turn[1], turn[0])};
  }
  static Matrix<3, 3> local_jacobian(const Pose2T&) { return Matrix<3, 3>::Identity(); }
  bool is_finite() const { return p.array().isFinite().all() && heading.array().isFinite().all(); }

  VectorT<T, 2> position() const { return p; }
  static Matrix<2, 3> position_jacobian() { return Matrix<2, 3>::Identity(); }
  Tangent rigid_motion(const VectorT<T, 2>& v, const VectorT<T, 1>& w) const {
    const VectorT<T, 2> rate = v + cross<T>(w, p);
    return {rate[0], rate[1], w[0]};
  }
};
using Pose2 = Pose2T<double>;

}  // namespace holdfast
