// What the factors between two positions share: x = p_b − p_a, its norm at and away from zero, and the chain rule to the tangents.
#pragma once

#include <holdfast/graph/factor.hpp>

namespace holdfast {

/// p_b − p_a in the world [m].
template <class A, class B>
Vector<space_dim<A>> displacement(const A& a, const B& b) {
  static_assert(space_dim<A> > 0 && space_dim<A> == space_dim<B>, "both variables need a position, in the same number of dimensions");
  return b.position() - a.position();
}

/// ‖x‖ and its gradient x/‖x‖. Below kZeroDistance both are zero (conventions, "Zero distance"); a NaN stays a NaN.
template <int N>
struct SafeNorm {
  double value;
  Vector<N> gradient;
};

template <int N>
SafeNorm<N> safe_norm(const Vector<N>& x) {
  const double norm = x.norm();
  if (norm < kZeroDistance) return {0, Vector<N>::Zero()};
  return {norm, x / norm};
}

/// D = d r / d x with x = p_b − p_a, carried to the tangents of a (variable 0) and b (variable 1).
template <class F, class Derived>
void set_displacement_jacobian(const Eigen::MatrixBase<Derived>& D, Jacobians<F>& J) {
  using A = typename F::Variables::template type<0>;
  using B = typename F::Variables::template type<1>;
  const Matrix<Derived::RowsAtCompileTime, Derived::ColsAtCompileTime> d = D;
  J.template wrt<0>().noalias() = -d * A::position_jacobian();
  J.template wrt<1>().noalias() = d * B::position_jacobian();
}

/// The Hessian by x of ½ (‖x‖ − radius)²: (1 − radius/n) I + (radius/n) u uᵀ with n = ‖x‖ and u = x/n. Outside the ball of this radius it
/// is positive definite, and also that of ½ times the squared distance to the ball.
template <int N>
Matrix<N, N> ball_hessian(const Vector<N>& x, double radius) {
  const double n = x.norm();
  const Vector<N> u = x / n;
  return (1 - radius / n) * Matrix<N, N>::Identity() + radius / n * u * u.transpose();
}

/// D = d² f / d x², x = p_b − p_a, carried to the tangents of a and b. Exact: positions are linear in their tangents.
template <class A, class B>
Matrix<A::dim + B::dim, A::dim + B::dim> displacement_hessian(const Matrix<space_dim<A>, space_dim<A>>& D) {
  Matrix<space_dim<A>, A::dim + B::dim> C;
  C << -A::position_jacobian(), B::position_jacobian();
  return C.transpose() * D * C;
}

}  // namespace holdfast
