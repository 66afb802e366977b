// Rotations in space: exponential, logarithm and the Jacobian of the logarithm, regular at the identity.
#pragma once

#include <Eigen/Geometry>
#include <holdfast/graph/math.hpp>

namespace holdfast::so3 {

template <class T>
using Quaternion = Eigen::Quaternion<T, Eigen::DontAlign>;

inline Matrix<3, 3> hat(const Vector<3>& w) {
  Matrix<3, 3> W;
  W << 0, -w[2], w[1], w[2], 0, -w[0], -w[1], w[0], 0;
  return W;
}

/// Unit quaternion of the rotation vector w [rad].
template <class T>
Quaternion<T> exp(const VectorT<T, 3>& w) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  const T theta2 = w.squaredNorm();
  if (theta2 < T(1e-8)) {  // series in θ², exact to rounding, and differentiable at 0
    const T k = T(0.5) - theta2 / T(48);
    return Quaternion<T>(T(1) - theta2 / T(8), k * w[0], k * w[1], k * w[2]);
  }
  const T theta = sqrt(theta2);
  const T k = sin(theta / T(2)) / theta;
  return Quaternion<T>(cos(theta / T(2)), k * w[0], k * w[1], k * w[2]);
}

/// Rotation vector [rad], at most π long, of a unit quaternion (either sign).
template <class T>
VectorT<T, 3> log(const Quaternion<T>& q) {
  using std::atan2;
  using std::sqrt;
  const T sign = q.w() < T(0) ? T(-1) : T(1);
  const VectorT<T, 3> v = sign * q.vec();
  const T w = sign * q.w();
  const T n2 = v.squaredNorm();
  if (n2 < T(1e-10)) return v * (T(2) / w * (T(1) - n2 / (T(3) * w * w)));
  const T n = sqrt(n2);
  return v * (T(2) * atan2(n, w) / n);
}

/// R_z(yaw) R_y(pitch) R_x(roll) from (roll, pitch, yaw) [rad].
template <class T>
Quaternion<T> from_roll_pitch_yaw(const VectorT<T, 3>& angles) {
  const auto turn = [&](int axis) { return exp<T>((angles[axis] * VectorT<T, 3>::Unit(axis)).eval()); };
  return (turn(2) * turn(1) * turn(0)).normalized();
}

/// (roll, pitch, yaw) [rad] of a rotation matrix, pitch in [−π/2, π/2]. The roll is that of R_z(−yaw) R: where roll and yaw turn about one
/// axis (pitch ±π/2) either is arbitrary, and both together are right.
template <class T>
VectorT<T, 3> roll_pitch_yaw(const MatrixT<T, 3, 3>& R) {
  using std::atan2;
  using std::cos;
  using std::sin;
  using std::sqrt;
  const T cosine = sqrt(R(0, 0) * R(0, 0) + R(1, 0) * R(1, 0));
  const T yaw = atan2(R(1, 0), R(0, 0)), s = sin(yaw), c = cos(yaw);
  return {atan2(s * R(0, 2) - c * R(1, 2), c * R(1, 1) - s * R(0, 1)), atan2(-R(2, 0), cosine), yaw};
}

/// J_r^{-1}(φ): Log(Exp(φ) Exp(δ)) = φ + J_r^{-1}(φ) δ + O(δ²).
inline Matrix<3, 3> right_jacobian_inverse(const Vector<3>& phi) {
  const double theta2 = phi.squaredNorm();
  const Matrix<3, 3> W = hat(phi);
  double k = 1.0 / 12 + theta2 / 720;
  if (theta2 > 1e-6) {
    const double theta = std::sqrt(theta2);
    k = 1 / theta2 - std::cos(theta / 2) / (2 * theta * std::sin(theta / 2));
  }
  return Matrix<3, 3>::Identity() + 0.5 * W + k * (W * W);
}

}  // namespace holdfast::so3
