#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <holdfast/graph/detail/semidefinite.hpp>
#include <holdfast/graph/math.hpp>
#include <limits>
#include <vector>

namespace holdfast::detail {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

double rounding(Eigen::Index n) { return static_cast<double>(n) * std::numeric_limits<double>::epsilon(); }

/// False where a pivot is not well above the rounding of its diagonal entry.
bool cholesky_root(const MatrixXd& m, MatrixXd& W) {
  const Eigen::LLT<MatrixXd> llt(m);
  W = llt.matrixU();
  return llt.info() == Eigen::Success && (W.diagonal().array().square() > rounding(m.rows()) * m.diagonal().array()).all();
}

/// C^{1/2} D; false where an eigenvalue of C is negative beyond rounding.
bool scaled_root(const MatrixXd& m, MatrixXd& W) {
  constexpr double kFloor = 1e-5, kNegative = 1e-9;
  const VectorXd D = m.diagonal().cwiseMax(kFloor * m.cwiseAbs().maxCoeff()).cwiseSqrt();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> spectrum(D.cwiseInverse().asDiagonal() * m * D.cwiseInverse().asDiagonal());
  if (spectrum.info() != Eigen::Success || spectrum.eigenvalues()[0] < -kNegative) return false;
  const double zero = static_cast<double>(m.rows()) * rounding(m.rows());
  const VectorXd roots = (spectrum.eigenvalues().array() > zero).select(spectrum.eigenvalues().cwiseMax(0).cwiseSqrt(), 0);
  const MatrixXd C_root = spectrum.eigenvectors() * roots.asDiagonal() * spectrum.eigenvectors().transpose();
  W = linked(m).select(C_root * D.asDiagonal(), MatrixXd::Zero(m.rows(), m.cols()));
  return true;
}

}  // namespace

Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> linked(const MatrixXd& m) {
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> links = m.array() != 0;
  for (Eigen::Index k = 0; k < m.rows(); ++k)
    for (Eigen::Index i = 0; i < m.rows(); ++i)
      for (Eigen::Index j = 0; j < m.rows(); ++j) links(i, j) = links(i, j) || (links(i, k) && links(k, j));
  return links;
}

bool semidefinite_root(int n, const double* m, double* W) {
  const Eigen::Map<const MatrixXd> all(m, n, n);
  std::vector<int> rows;  // that are not 0
  for (int i = 0; i < n; ++i)
    if ((all.col(i).array() != 0).any()) rows.push_back(i);
  const int rank = static_cast<int>(rows.size());
  MatrixXd part(rank, rank), root(rank, rank);
  for (int i = 0; i < rank; ++i)
    for (int j = 0; j < rank; ++j) part(i, j) = all(rows[i], rows[j]);
  if (rank > 0 && !cholesky_root(part, root) && !scaled_root(part, root)) return false;
  Eigen::Map<MatrixXd> out(W, n, n);
  out.setZero();
  for (int i = 0; i < rank; ++i)
    for (int j = 0; j < rank; ++j) out(rows[i], rows[j]) = root(i, j);
  return true;
}

}  // namespace holdfast::detail
