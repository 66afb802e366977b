// From sigmas, covariance Σ or information Λ = Σ⁻¹ to the square root information W that whitens a residual: Wᵀ W = Λ.
//
//   sqrt_information_from_…      W upper triangular with a positive diagonal: W = Lᵀ of the Cholesky factor Λ = L Lᵀ. It is
//                                unique, so the same noise given as Σ or as Λ gives the same residual.
//   symmetric_sqrt_information_… W = Σ^{-1/2}, symmetric: paper A's choice. For a per-component loss the choice of root matters.
//
// A matrix that is not finite, symmetric (to 1e-9 of its largest entry) and positive definite throws BadNumber.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <holdfast/graph/require.hpp>
#include <limits>

namespace holdfast {

namespace detail {  // of run-time size, so that a program compiles them once: they are called when a factor is made, never in a solve

inline void require_symmetric(const char* what, const Eigen::MatrixXd& m) {
  require_finite(what, m);
  Eigen::Index i = 0, j = 0;
  if ((m - m.transpose()).cwiseAbs().maxCoeff(&i, &j) > 1e-9 * m.cwiseAbs().maxCoeff())
    fail<BadNumber>(what, "(", i, ",", j, ") = ", m(i, j), " but ", what, "(", j, ",", i, ") = ", m(j, i),
                    "; it must be symmetric; check the order of its entries");
}

/// L with L Lᵀ = m, or by_last_component U with U Uᵀ = m. The pivots are judged against the diagonal: units do not matter.
inline Eigen::MatrixXd cholesky(const char* what, const Eigen::MatrixXd& m, bool by_last_component = false) {
  require_symmetric(what, m);
  if (by_last_component) return cholesky(what, m.reverse()).reverse();
  const Eigen::LLT<Eigen::MatrixXd> llt(m);
  const Eigen::MatrixXd L = llt.matrixL();
  const double rounding = static_cast<double>(m.rows()) * std::numeric_limits<double>::epsilon();
  if (llt.info() != Eigen::Success || !(L.diagonal().array().square() > rounding * m.diagonal().array()).all())
    fail<BadNumber>(what, " has the eigenvalue ",
                    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(m, Eigen::EigenvaluesOnly).eigenvalues()[0], " (diagonal [",
                    m.diagonal().transpose(),
                    "]) and must be positive definite; check the units and signs of its entries, or give every direction some noise");
  return L;
}

/// U⁻¹ with U Uᵀ = Σ, upper triangular like Lᵀ of Σ⁻¹, and found without inverting Σ.
inline Eigen::MatrixXd sqrt_of_inverse(const char* what, const Eigen::MatrixXd& covariance) {
  const Eigen::MatrixXd U = cholesky(what, covariance, true);
  return U.triangularView<Eigen::Upper>().solve(Eigen::MatrixXd::Identity(U.rows(), U.cols()));
}

inline Eigen::MatrixXd symmetric_sqrt_of_inverse(const char* what, const Eigen::MatrixXd& covariance) {
  cholesky(what, covariance);  // states the rule
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(covariance).operatorInverseSqrt();
}

}  // namespace detail

template <int N>
Matrix<N, N> sqrt_information_from_sigmas(const Vector<N>& sigmas, const char* what = "sigmas") {
  require_positive(what, sigmas);
  return sigmas.cwiseInverse().asDiagonal();
}

template <int N>
Matrix<N, N> sqrt_information_from_information(const Matrix<N, N>& information, const char* what = "information") {
  return detail::cholesky(what, information).transpose();
}

template <int N>
Matrix<N, N> sqrt_information_from_covariance(const Matrix<N, N>& covariance, const char* what = "covariance") {
  return detail::sqrt_of_inverse(what, covariance);
}

template <int N>
Matrix<N, N> symmetric_sqrt_information_from_covariance(const Matrix<N, N>& covariance, const char* what = "covariance") {
  return detail::symmetric_sqrt_of_inverse(what, covariance);
}

}  // namespace holdfast
