// A motion state in the plane whose turn rate is estimated, too: [px vx py vy ω] [m, m/s, rad/s]. A vector space: retract adds.
#pragma once

#include <holdfast/graph/variables/kinematic.hpp>

namespace holdfast {

template <class T>
struct Turning2T {
  static constexpr int dim = 5;
  static constexpr int space_dim = 2;
  static constexpr bool is_vector_space = true;
  using Tangent = VectorT<T, 5>;
  template <class U>
  using rebind = Turning2T<U>;

  Tangent value = Tangent::Zero();

  Turning2T() = default;
  template <class Derived>
  Turning2T(const Eigen::MatrixBase<Derived>& v) : value(v) {}
  Turning2T(T px, T vx, T py, T vy, T turn_rate) : value(px, vx, py, vy, turn_rate) {}
  Turning2T(const Motion2T<T>& motion, T turn_rate) { value << motion.value, turn_rate; }

  static const char* name() { return "Turning2"; }
  template <class U>
  rebind<U> cast() const {
    return rebind<U>(value.template cast<U>().eval());
  }

  Turning2T retract(const Tangent& delta) const { return Turning2T((value + delta).eval()); }
  Tangent local(const Turning2T& other) const { return other.value - value; }
  bool is_finite() const { return value.array().isFinite().all(); }

  Motion2T<T> motion() const { return Motion2T<T>(value.template head<4>()); }
  const T& turn_rate() const { return value[4]; }                  ///< ω, counter-clockwise [rad/s]
  VectorT<T, 2> position() const { return {value[0], value[2]}; }  ///< p_world [m]
  const T& x() const { return value[0]; }                          ///< p_world [m]
  const T& y() const { return value[2]; }                          ///< p_world [m]
  static Matrix<2, 5> position_jacobian() {
    Matrix<2, 5> C = Matrix<2, 5>::Zero();
    C(0, 0) = C(1, 2) = 1;
    return C;
  }

  /// Tangent velocity when the world translates by v and turns by w about its origin: the turn rate stays.
  Tangent rigid_motion(const VectorT<T, 2>& v, const VectorT<T, 1>& w) const {
    Tangent rate = Tangent::Zero();
    rate.template head<4>() = motion().rigid_motion(v, w);
    return rate;
  }
};
using Turning2 = Turning2T<double>;

}  // namespace holdfast
