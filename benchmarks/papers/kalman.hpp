// The Kalman filter, plain and extended, a function a step. Sizes are fixed or Eigen::Dynamic.
//
//   predicted    x ← F x,  P ← F P Fᵀ + Q
//   Innovation   r = z − h(x),  S = H P Hᵀ + R        linear: h(x) = H x; extended: H = ∂h/∂x at the predicted x
//   corrected    K = P Hᵀ S⁻¹,  x ← x + K r,  P ← (I − K H) P (I − K H)ᵀ + K R Kᵀ, made symmetric
//
// The last is Joseph's form. The shorter P − K S Kᵀ is not for filters that weigh samples as differently as paper B's: it diverges there.
#pragma once

#include <Eigen/Cholesky>
#include <holdfast/graph/math.hpp>

namespace holdfast::bench {

template <int N>
struct Gaussian {
  Vector<N> mean;
  Matrix<N, N> covariance;
};

template <int M>
struct Innovation {
  Vector<M> r;
  Matrix<M, M> S;

  /// rᵀ S⁻¹ r: χ² with M degrees of freedom where the filter is consistent.
  double normalized_squared() const { return r.dot(S.llt().solve(r)); }
  /// ln N(r; 0, S).
  double log_likelihood() const {
    const Eigen::LLT<Matrix<M, M>> llt(S);
    const double log_sqrt_determinant = llt.matrixLLT().diagonal().array().log().sum();
    return -0.5 * (r.dot(llt.solve(r)) + static_cast<double>(r.size()) * std::log(2 * kPi)) - log_sqrt_determinant;
  }
};

template <int N>
Gaussian<N> predicted(const Gaussian<N>& x, const Matrix<N, N>& F, const Matrix<N, N>& Q) {
  return {F * x.mean, F * x.covariance * F.transpose() + Q};
}

template <int N, int M>
Matrix<M, M> innovation_covariance(const Matrix<N, N>& P, const Matrix<M, N>& H, const Matrix<M, M>& R) {
  return H * P * H.transpose() + R;
}

template <int N, int M>
Gaussian<N> corrected(const Gaussian<N>& x, const Innovation<M>& innovation, const Matrix<M, N>& H, const Matrix<M, M>& R) {
  const Matrix<N, M> K = innovation.S.llt().solve(H * x.covariance).transpose();
  const Matrix<N, N> rest = Matrix<N, N>::Identity(x.mean.size(), x.mean.size()) - K * H;
  const Matrix<N, N> P = rest * x.covariance * rest.transpose() + K * R * K.transpose();
  return {x.mean + K * innovation.r, 0.5 * (P + P.transpose())};
}

/// A linear measurement z = H x + N(0, R), in one go.
template <int N, int M>
Gaussian<N> corrected(const Gaussian<N>& x, const Vector<M>& z, const Matrix<M, N>& H, const Matrix<M, M>& R) {
  return corrected(x, Innovation<M>{z - H * x.mean, innovation_covariance(x.covariance, H, R)}, H, R);
}

}  // namespace holdfast::bench
