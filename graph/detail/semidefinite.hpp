// Square roots of information matrices that say nothing of some directions (zero rows, or of lower rank): a GPS position as a prior on a
// pose, the odometry of a robot that knows no height.
#pragma once

#include <Eigen/Core>

namespace holdfast::detail {

/// W with Wᵀ W = m, n × n, column-major, for a symmetric positive semidefinite m; false where m is indefinite, and then W is left alone.
///
/// Rows of zeros stay rows of zeros; the rest, where it has full rank, is Lᵀ of its Cholesky factor. Where it has not, W = C^{1/2} D with
/// D = diag(√m_ii) and C = D⁻¹ m D⁻¹, so that units do not matter. An eigenvalue of C counts as 0 above −1e-9: that is rounding. (Entries
/// of D are at least √(1e-5 max m): what is rounding in the largest entries must not count as information in the smallest.)
bool semidefinite_root(int n, const double* m, double* W);

/// Which components the entries that are not 0 link, directly or through others. What they do not link (the axes of a motion, say) stays
/// separate in any function of the matrix, and must not meet again through rounding: solvers skip zeros.
Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> linked(const Eigen::MatrixXd& m);

}  // namespace holdfast::detail
