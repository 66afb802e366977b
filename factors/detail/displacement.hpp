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

namespace detail {

/// A point: its position is its tangent.
template <class V>
inline constexpr bool is_point = V::dim == space_dim<V>&& is_vector_space<V>;

/// out = sign D P, column by column: D is M × N (d r / d x), P is N × K (d position / d tangent). Loops, because Eigen's products of small
/// matrices cost the compiler a second for every pair of variables.
template <int M, int N, int K>
void carry_to_tangent(const Matrix<M, N>& D, const Matrix<N, K>& P, double sign, double* out) {
  for (int column = 0; column < K; ++column)
    for (int row = 0; row < M; ++row) {
      double sum = 0;
      for (int i = 0; i < N; ++i) sum += D(row, i) * P(i, column);
      *out++ = sign * sum;
    }
}

/// out = sign D d position / d tangent.
template <class V, int M>
void carry_to(const Matrix<M, space_dim<V>>& D, double sign, double* out) {
  if constexpr (is_point<V>)
    Eigen::Map<Matrix<M, V::dim>>(out, M, V::dim) = sign * D;
  else
    carry_to_tangent<M, space_dim<V>, V::dim>(D, V::position_jacobian(), sign, out);
}

}  // namespace detail

/// D = d r / d x with x = p_b − p_a, carried to the tangents of a (variable 0) and b (variable 1).
template <class F>
void set_displacement_jacobian(const Matrix<F::residual_dim, space_dim<typename F::Variables::template type<0>>>& D, Jacobians<F>& J) {
  using A = typename F::Variables::template type<0>;
  using B = typename F::Variables::template type<1>;
  constexpr int M = F::residual_dim;
  detail::carry_to<A, M>(D, -1, J.all.data());
  detail::carry_to<B, M>(D, 1, J.all.data() + M * A::dim);
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
  constexpr int N = space_dim<A>, dim = A::dim + B::dim;
  Matrix<dim, dim> H;
  if constexpr (detail::is_point<A> && detail::is_point<B>) {
    for (int column = 0; column < N; ++column)
      for (int row = 0; row < N; ++row) {
        H(row, column) = H(N + row, N + column) = D(row, column);
        H(N + row, column) = H(row, N + column) = -D(row, column);
      }
  } else {
    Matrix<N, dim> C, DC;
    detail::carry_to<A, N>(Matrix<N, N>::Identity(), -1, C.data());
    detail::carry_to<B, N>(Matrix<N, N>::Identity(), 1, C.data() + N * A::dim);
    detail::carry_to_tangent<N, N, dim>(D, C, 1, DC.data());
    detail::carry_to_tangent<dim, N, dim>(C.transpose(), DC, 1, H.data());
  }
  return H;
}

}  // namespace holdfast
