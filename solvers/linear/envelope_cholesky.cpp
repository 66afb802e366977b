#include <Eigen/Core>
#include <algorithm>
#include <holdfast/solvers/linear/internal/envelope_cholesky.hpp>

namespace holdfast {
namespace {

// a − Σ x_k y_k
inline double minus_dot(double a, const double* x, const double* y, int n) {
  if (n >= 8) return a - Eigen::Map<const Eigen::VectorXd>(x, n).dot(Eigen::Map<const Eigen::VectorXd>(y, n));
  for (const double* const end = x + n; x < end; ++x, ++y) a -= *x * *y;
  return a;
}

}  // namespace

void EnvelopeCholesky::set_layout(const std::vector<int>& first) {
  first_.assign(first.begin(), first.end());
  origin_.clear();
  int entries = 0;
  for (int row = 0; row < size(); ++row) {
    origin_.push_back(entries - first_[row]);
    entries += row - first_[row] + 1;
  }
  matrix_.resize(entries);
  lower_.resize(entries);
  inverse_diagonal_.resize(size());
}

// Row by row: u_j = a_ij − Σ_k u_k l_jk, then l_ij = u_j / d_j and d_i = a_ii − Σ u_j l_ij.
bool EnvelopeCholesky::factor(const std::vector<double>& damping) {
  const int *const first = first_.data(), *const origin = origin_.data();
  double* const lower = lower_.data();
  double* const inverse = inverse_diagonal_.data();
  for (int i = 0, n = size(); i < n; ++i) {
    const int begin = first[i];
    const double* a = matrix_.data() + origin[i];
    double* u = lower + origin[i];
    double d = a[i] + damping[i];
    for (int j = begin; j < i; ++j) {
      const int k = std::max(begin, first[j]);
      u[j] = minus_dot(a[j], u + k, lower + origin[j] + k, j - k);
    }
    for (int j = begin; j < i; ++j) {
      const double l = u[j] * inverse[j];
      d -= u[j] * l;
      u[j] = l;
    }
    if (!(d > 0)) return false;
    inverse[i] = 1 / d;
  }
  return true;
}

void EnvelopeCholesky::solve(std::vector<double>& right) const {
  const int *const first = first_.data(), *const origin = origin_.data();
  double* const x = right.data();
  const int n = size();
  for (int i = 0; i < n; ++i) x[i] = minus_dot(x[i], lower_.data() + origin[i] + first[i], x + first[i], i - first[i]);
  for (int i = 0; i < n; ++i) x[i] *= inverse_diagonal_[i];
  for (int i = n - 1; i >= 0; --i) {
    const double* const row = lower_.data() + origin[i];
    const double known = x[i];
    for (int j = first[i]; j < i; ++j) x[j] -= row[j] * known;
  }
}

}  // namespace holdfast
