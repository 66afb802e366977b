// Points and motion states: the position and its time derivatives, axis by axis (interleaved as in paper A):
// Point2 [px py], Motion2 [px ṗx py ṗy], Accel2 [px ṗx p̈x py ṗy p̈y], and the same in space. Also Scalar.
// They are vector spaces: retract adds.
#pragma once

#include <array>
#include <holdfast/graph/manifold.hpp>

namespace holdfast {

template <class T, int Axes, int Order>
struct Kinematic {
  static constexpr int axes = Axes;
  static constexpr int order = Order;  ///< 1: position; 2: and velocity; 3: and acceleration
  static constexpr int dim = Axes * Order;
  static constexpr int space_dim = Axes;
  static constexpr bool is_vector_space = true;
  using Tangent = VectorT<T, dim>;
  using Position = VectorT<T, Axes>;
  template <class U>
  using rebind = Kinematic<U, Axes, Order>;

  Tangent value = Tangent::Zero();  ///< [m, m/s, m/s²] per axis

  Kinematic() = default;
  template <class Derived>
  Kinematic(const Eigen::MatrixBase<Derived>& v) : value(v) {}
  template <class... S, class = std::enable_if_t<sizeof...(S) == dim && (std::is_convertible_v<S, T> && ...)>>
  Kinematic(S... s) {
    int i = 0;
    ((value[i++] = T(s)), ...);
  }

  static const char* name() {
    static constexpr std::array<const char*, 6> names{"Point2", "Motion2", "Accel2", "Point3", "Motion3", "Accel3"};
    return names[(Axes - 2) * 3 + (Order - 1)];
  }
  template <class U>
  rebind<U> cast() const {
    return rebind<U>(value.template cast<U>().eval());
  }

  Kinematic retract(const Tangent& delta) const { return Kinematic((value + delta).eval()); }
  Tangent local(const Kinematic& other) const { return other.value - value; }
  bool is_finite() const { return value.array().isFinite().all(); }

  /// The k-th time derivative of the position in the world.
  Position derivative(int k) const {
    Position d;
    for (int axis = 0; axis < Axes; ++axis) d[axis] = value[axis * Order + k];
    return d;
  }
  Position position() const { return derivative(0); }
  const T& x() const { return value[0]; }      ///< p_world [m]
  const T& y() const { return value[Order]; }  ///< p_world [m]
  const T& z() const {                         ///< p_world [m]
    static_assert(Axes == 3, "a point in the plane has no z");
    return value[2 * Order];
  }
  static Matrix<Axes, dim> position_jacobian() {
    Matrix<Axes, dim> C = Matrix<Axes, dim>::Zero();
    for (int axis = 0; axis < Axes; ++axis) C(axis, axis * Order) = 1;
    return C;
  }

  /// Tangent velocity when the world translates by v and turns by w about its origin.
  Tangent rigid_motion(const Position& v, const VectorT<T, rotation_dim<Axes>>& w) const {
    Tangent motion;
    for (int k = 0; k < Order; ++k) {
      Position rate = cross<T>(w, derivative(k));
      if (k == 0) rate += v;
      for (int axis = 0; axis < Axes; ++axis) motion[axis * Order + k] = rate[axis];
    }
    return motion;
  }
};

template <class T>
using Point2T = Kinematic<T, 2, 1>;
template <class T>
using Point3T = Kinematic<T, 3, 1>;
template <class T>
using Motion2T = Kinematic<T, 2, 2>;
template <class T>
using Motion3T = Kinematic<T, 3, 2>;
template <class T>
using Accel2T = Kinematic<T, 2, 3>;
template <class T>
using Accel3T = Kinematic<T, 3, 3>;

using Point2 = Point2T<double>;
using Point3 = Point3T<double>;
using Motion2 = Motion2T<double>;
using Motion3 = Motion3T<double>;
using Accel2 = Accel2T<double>;
using Accel3 = Accel3T<double>;

/// One number: a distance that did not arrive, a clock bias, a turn rate.
template <class T>
struct ScalarT {
  static constexpr int dim = 1;
  static constexpr bool is_vector_space = true;
  using Tangent = VectorT<T, 1>;
  template <class U>
  using rebind = ScalarT<U>;

  T value{0};

  ScalarT() = default;
  ScalarT(T v) : value(v) {}
  static const char* name() { return "Scalar"; }
  template <class U>
  rebind<U> cast() const {
    return rebind<U>(U(value));
  }
  ScalarT retract(const Tangent& delta) const { return ScalarT(value + delta[0]); }
  Tangent local(const ScalarT& other) const { return Tangent(other.value - value); }
  bool is_finite() const { return std::isfinite(value); }
};
using Scalar = ScalarT<double>;

}  // namespace holdfast
