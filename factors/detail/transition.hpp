// Motion over a time T with the highest derivative constant: per axis F = [1 T; 0 1] or [1 T T²/2; 0 1 T; 0 0 1], block diagonal.
// F is never formed in the inner loop: it is applied to a state, or to the columns of a whitening matrix.
#pragma once

#include <holdfast/graph/factor.hpp>
#include <holdfast/graph/variables/kinematic.hpp>

namespace holdfast {

/// F(T) x.
template <class V>
typename V::Tangent predicted(const V& x, double T) {
  typename V::Tangent y = x.value;
  for (int i = 0; i < V::dim; i += V::order) {
    if constexpr (V::order == 3) {
      y[i] += 0.5 * T * T * y[i + 2];
      y[i] += T * y[i + 1];
      y[i + 1] += T * y[i + 2];
    } else {
      y[i] += T * y[i + 1];
    }
  }
  return y;
}

/// W F(T).
template <class V>
Matrix<V::dim, V::dim> times_transition(Matrix<V::dim, V::dim> W, double T) {
  for (int i = 0; i < V::dim; i += V::order) {
    if constexpr (V::order == 3) W.col(i + 2) += 0.5 * T * T * W.col(i) + T * W.col(i + 1);
    W.col(i + 1) += T * W.col(i);
  }
  return W;
}

/// F(T).
template <class V>
Matrix<V::dim, V::dim> transition(double T) {
  return times_transition<V>(Matrix<V::dim, V::dim>::Identity(), T);
}

/// The same block for each axis.
template <class V>
Matrix<V::dim, V::dim> on_each_axis(const Matrix<V::order, V::order>& block) {
  Matrix<V::dim, V::dim> all = Matrix<V::dim, V::dim>::Zero();
  for (int i = 0; i < V::dim; i += V::order) all.template block<V::order, V::order>(i, i) = block;
  return all;
}

/// W (F(T) x_k − x_next) and its constant Jacobian.
template <class F, class V>
typename V::Tangent transition_residual(const Matrix<V::dim, V::dim>& W, double T, const V& x, const V& next, Jacobians<F>* J) {
  if (J != nullptr) {
    J->template wrt<0>() = times_transition<V>(W, T);
    J->template wrt<1>() = -W;
  }
  return W * (predicted(x, T) - next.value);
}

}  // namespace holdfast
