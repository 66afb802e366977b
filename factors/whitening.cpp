#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <holdfast/factors/whitening.hpp>
#include <holdfast/graph/detail/semidefinite.hpp>
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

[[noreturn]] void refuse(const char* what, const MatrixXd& m, const char* rule) {
  fail<BadNumber>(what, " has the eigenvalue ", Eigen::SelfAdjointEigenSolver<MatrixXd>(m, Eigen::EigenvaluesOnly).eigenvalues()[0],
                  " (diagonal [", m.diagonal().transpose(), "]) and must be ", rule);
}
constexpr const char* kDefinite = "positive definite; check the units and signs of its entries, or give every direction some noise";
constexpr const char* kSemidefinite =
    "positive semidefinite; check the units and signs of its entries; a row of zeros says nothing of its direction";

// L with L Lᵀ = m; empty where m is not positive definite. The pivots are judged against the diagonal: units do not matter.
MatrixXd cholesky(const char* what, const MatrixXd& m) {
  require_symmetric(what, m);
  const Eigen::LLT<MatrixXd> llt(m);
  const MatrixXd L = llt.matrixL();
  const double rounding = static_cast<double>(m.rows()) * std::numeric_limits<double>::epsilon();
  const bool definite = llt.info() == Eigen::Success && (L.diagonal().array().square() > rounding * m.diagonal().array()).all();
  return definite ? L : MatrixXd();
}

MatrixXd definite_cholesky(const char* what, const MatrixXd& m) {
  MatrixXd L = cholesky(what, m);
  if (L.size() == 0) refuse(what, m, kDefinite);
  return L;
}

Eigen::Map<const MatrixXd> square(int n, const double* m) { return {m, n, n}; }
Eigen::Map<MatrixXd> square(int n, double* m) { return {m, n, n}; }

}  // namespace

void root_of_information(const char* what, int n, const double* m, double* W) {
  const MatrixXd L = cholesky(what, square(n, m));
  if (L.size() != 0)
    square(n, W) = L.transpose();
  else if (!semidefinite_root(n, m, W))
    refuse(what, square(n, m), kSemidefinite);
}

void sqrt_of_inverse(const char* what, int n, const double* covariance, double* W) {
  const MatrixXd reversed = square(n, covariance).reverse();  // by the last component first: U Uᵀ = Σ without inverting Σ
  const MatrixXd U = definite_cholesky(what, reversed).reverse();
  square(n, W) = U.triangularView<Eigen::Upper>().solve(MatrixXd::Identity(n, n));
}

void symmetric_sqrt_of_inverse(const char* what, int n, const double* covariance, double* W) {
  definite_cholesky(what, square(n, covariance));  // states the rule
  const MatrixXd root = Eigen::SelfAdjointEigenSolver<MatrixXd>(square(n, covariance)).operatorInverseSqrt();
  square(n, W) = linked(square(n, covariance)).select(root, MatrixXd::Zero(n, n));
}

void symmetric_root_of_information(const char* what, int n, const double* m, double* W) {
  root_of_information(what, n, m, W);  // states the rule
  const Eigen::SelfAdjointEigenSolver<MatrixXd> spectrum(square(n, m));
  const MatrixXd root =
      spectrum.eigenvectors() * spectrum.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal() * spectrum.eigenvectors().transpose();
  square(n, W) = linked(square(n, m)).select(root, MatrixXd::Zero(n, n));
}

}  // namespace holdfast::detail
