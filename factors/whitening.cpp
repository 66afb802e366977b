#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <holdfast/factors/whitening.hpp>
#include <limits>

namespace holdfast::detail {
namespace {

using Eigen::MatrixXd;

void require_symmetric(const char* what, const MatrixXd& m) {
  require_finite(what, m);
  Eigen::Index i = 0, j = 0;
  if ((m - m.transpose()).cwiseAbs().maxCoeff(&i, &j) > 1e-9 * m.cwiseAbs().maxCoeff())
    fail<BadNumber>(what, "(", i, ",", j, ") = ", m(i, j), " but ", what, "(", j, ",", i, ") = ", m(j, i),
                    "; it must be symmetric; check the order of its entries");
}

// L with L Lᵀ = m. The pivots are judged against the diagonal: units do not matter.
MatrixXd cholesky(const char* what, const MatrixXd& m) {
  require_symmetric(what, m);
  const Eigen::LLT<MatrixXd> llt(m);
  const MatrixXd L = llt.matrixL();
  const double rounding = static_cast<double>(m.rows()) * std::numeric_limits<double>::epsilon();
  if (llt.info() != Eigen::Success || !(L.diagonal().array().square() > rounding * m.diagonal().array()).all())
    fail<BadNumber>(what, " has the eigenvalue ", Eigen::SelfAdjointEigenSolver<MatrixXd>(m, Eigen::EigenvaluesOnly).eigenvalues()[0],
                    " (diagonal [", m.diagonal().transpose(),
                    "]) and must be positive definite; check the units and signs of its entries, or give every direction some noise");
  return L;
}

// Which components the entries that are not 0 link, directly or through others. What they do not link (the axes of a motion, say) stays
// separate in any function of the matrix, and must not meet again through rounding: solvers skip zeros.
Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> linked(const MatrixXd& m) {
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> links = m.array() != 0;
  for (Eigen::Index k = 0; k < m.rows(); ++k)
    for (Eigen::Index i = 0; i < m.rows(); ++i)
      for (Eigen::Index j = 0; j < m.rows(); ++j) links(i, j) = links(i, j) || (links(i, k) && links(k, j));
  return links;
}

Eigen::Map<const MatrixXd> square(int n, const double* m) { return {m, n, n}; }
Eigen::Map<MatrixXd> square(int n, double* m) { return {m, n, n}; }

}  // namespace

void cholesky_transposed(const char* what, int n, const double* m, double* W) { square(n, W) = cholesky(what, square(n, m)).transpose(); }

void sqrt_of_inverse(const char* what, int n, const double* covariance, double* W) {
  const MatrixXd reversed = square(n, covariance).reverse();  // by the last component first: U Uᵀ = Σ without inverting Σ
  const MatrixXd U = cholesky(what, reversed).reverse();
  square(n, W) = U.triangularView<Eigen::Upper>().solve(MatrixXd::Identity(n, n));
}

void symmetric_sqrt_of_inverse(const char* what, int n, const double* covariance, double* W) {
  cholesky(what, square(n, covariance));  // states the rule
  const MatrixXd root = Eigen::SelfAdjointEigenSolver<MatrixXd>(square(n, covariance)).operatorInverseSqrt();
  square(n, W) = linked(square(n, covariance)).select(root, MatrixXd::Zero(n, n));
}

}  // namespace holdfast::detail
