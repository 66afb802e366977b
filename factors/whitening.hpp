// From sigmas, covariance Σ or information Λ = Σ⁻¹ to the square root information W that whitens a residual: Wᵀ W = Λ.
//
//   sqrt_information_from_…      W upper triangular with a positive diagonal: W = Lᵀ of the Cholesky factor Λ = L Lᵀ. It is
//                                unique, so the same noise given as Σ or as Λ gives the same residual.
//   symmetric_sqrt_information_… W = Σ^{-1/2} = Λ^{1/2}, symmetric: paper A's choice. For a per-component loss the choice of root matters.
//
// A covariance must be positive definite. An information may be positive semidefinite: it says nothing of the directions in which it is 0.
// A row of zeros in Λ is one in W (a GPS position as a prior on a pose: the rows of the rotation are 0); of any other Λ of lower rank see
// graph/detail/semidefinite.hpp. A matrix that is not finite, not symmetric (to 1e-9 of its largest entry) or indefinite throws BadNumber,
// which names the eigenvalue.
#pragma once

#include <holdfast/graph/require.hpp>

namespace holdfast {

namespace detail {  // of run-time size and compiled once: they are called when a factor is made, never in a solve; n × n, column-major
void root_of_information(const char* what, int n, const double* information, double* W);
void sqrt_of_inverse(const char* what, int n, const double* covariance, double* W);  // U⁻¹ with U Uᵀ = Σ: upper triangular like Lᵀ of Σ⁻¹
void symmetric_sqrt_of_inverse(const char* what, int n, const double* covariance, double* W);
void symmetric_root_of_information(const char* what, int n, const double* information, double* W);

template <int N, class Function>
Matrix<N, N> whitened(Function function, const char* what, const Matrix<N, N>& m) {
  Matrix<N, N> W;
  function(what, N, m.data(), W.data());
  return W;
}
}  // namespace detail

template <int N>
Matrix<N, N> sqrt_information_from_sigmas(const Vector<N>& sigmas, const char* what = "sigmas") {
  require_positive(what, sigmas);
  return sigmas.cwiseInverse().asDiagonal();
}

template <int N>
Matrix<N, N> sqrt_information_from_information(const Matrix<N, N>& information, const char* what = "information") {
  return detail::whitened<N>(detail::root_of_information, what, information);
}

template <int N>
Matrix<N, N> sqrt_information_from_covariance(const Matrix<N, N>& covariance, const char* what = "covariance") {
  return detail::whitened<N>(detail::sqrt_of_inverse, what, covariance);
}

template <int N>
Matrix<N, N> symmetric_sqrt_information_from_covariance(const Matrix<N, N>& covariance, const char* what = "covariance") {
  return detail::whitened<N>(detail::symmetric_sqrt_of_inverse, what, covariance);
}

template <int N>
Matrix<N, N> symmetric_sqrt_information_from_information(const Matrix<N, N>& information, const char* what = "information") {
  return detail::whitened<N>(detail::symmetric_root_of_information, what, information);
}

}  // namespace holdfast
