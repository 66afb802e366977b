// What is left on the ends of a chain of linear motion factors when the states between are marginalised.
#pragma once

#include <Eigen/Dense>
#include <holdfast/graph/factor.hpp>

namespace holdfast::testing {

/// JᵀJ of the factor: the information it gives on both its states.
template <class F, class V>
Eigen::MatrixXd information(const F& factor, const V& x) {
  Jacobians<F> J;
  factor(x, x, &J);
  return J.all.transpose() * J.all;
}

/// m copies of the factor in a chain, all states but the first and the last eliminated (Schur complement).
template <class F, class V>
Eigen::MatrixXd information_of_ends(const F& factor, const V& x, int m) {
  constexpr int n = V::dim;
  Eigen::MatrixXd chain = information(factor, x);
  for (int i = 1; i < m; ++i) {
    Eigen::MatrixXd both = Eigen::MatrixXd::Zero(3 * n, 3 * n);  // first, middle, last
    both.topLeftCorner(2 * n, 2 * n) += chain;
    both.bottomRightCorner(2 * n, 2 * n) += information(factor, x);
    Eigen::MatrixXd ends(2 * n, 2 * n), coupling(2 * n, n);
    ends << both.block(0, 0, n, n), both.block(0, 2 * n, n, n), both.block(2 * n, 0, n, n), both.block(2 * n, 2 * n, n, n);
    coupling << both.block(0, n, n, n), both.block(2 * n, n, n, n);
    chain = ends - coupling * both.block(n, n, n, n).ldlt().solve(coupling.transpose());
  }
  return chain;
}

/// Σ of the motion noise: (Wᵀ W)⁻¹.
template <int N>
Matrix<N, N> covariance(const Matrix<N, N>& W) {
  return (W.transpose() * W).inverse();
}

}  // namespace holdfast::testing
