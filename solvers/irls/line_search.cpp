#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <holdfast/solvers/irls/internal/line_search.hpp>

namespace holdfast::detail {
namespace {

template <class RhoOfComponent>
Phi sum_components(int rows, const double* weights, const double* r, const double* Jd, double alpha, const RhoOfComponent& rho_of) {
  Phi phi;
  for (int row = 0; row < rows; ++row) {
    const double x = r[row] + alpha * Jd[row], d = Jd[row];
    const Rho rho = rho_of(x);
    phi.value += weights[row] * 0.5 * rho.value;
    phi.slope += weights[row] * rho.first * x * d;
    phi.curvature += weights[row] * (rho.first + 2 * x * x * rho.second) * d * d;
  }
  return phi;
}

// The most common loss of all, without a branch: ψ(x) = clamp(x, −a, a), ½ρ = ψ(x − ½ψ).
template <int Lanes>
Phi sum_huber(int rows, const double* weights, const double* r, const double* Jd, double alpha, double a) {
  using Packet = Eigen::Array<double, Lanes, 1>;
  Packet value = Packet::Zero(), slope = Packet::Zero(), curvature = Packet::Zero();
  for (int row = 0; row + Lanes <= rows; row += Lanes) {
    const Packet w = Eigen::Map<const Packet>(weights + row), d = Eigen::Map<const Packet>(Jd + row);
    const Packet x = Eigen::Map<const Packet>(r + row) + alpha * d;
    const Packet psi = x.min(a).max(-a);
    value += w * psi * (x - 0.5 * psi);
    slope += w * psi * d;
    curvature += (psi == x).select(w * d * d, Packet::Zero());
  }
  Phi phi{value.sum(), slope.sum(), curvature.sum()};
  if constexpr (Lanes > 1) {
    const int done = rows - rows % Lanes;
    phi += sum_huber<1>(rows - done, weights + done, r + done, Jd + done, alpha, a);
  }
  return phi;
}

Phi sum_blocks(const Loss& loss, int rows, int m, const double* weights, const double* r, const double* Jd, double alpha) {
  Phi phi;
  for (int row = 0; row < rows; row += m, weights += m, r += m, Jd += m) {
    double s = 0, xd = 0, dd = 0;
    for (int c = 0; c < m; ++c) {
      const double x = r[c] + alpha * Jd[c];
      s += x * x;
      xd += x * Jd[c];
      dd += Jd[c] * Jd[c];
    }
    const Rho rho = loss.rho(s, m);
    phi.value += *weights * 0.5 * rho.value;
    phi.slope += *weights * rho.first * xd;
    phi.curvature += *weights * (rho.first * dd + 2 * rho.second * xd * xd);
  }
  return phi;
}

}  // namespace

Phi phi_of_rows(const Loss& loss, int rows, int block, const double* weights, const double* r, const double* Jd, double alpha) {
  if (loss.kind == Loss::Kind::Squared) return sum_components(rows, weights, r, Jd, alpha, [](double x) { return Rho{x * x, 1, 0}; });
  if (!loss.per_component && block > 1) return sum_blocks(loss, rows, block, weights, r, Jd, alpha);
  if (loss.kind == Loss::Kind::Huber && !loss.one_sided) return sum_huber<4>(rows, weights, r, Jd, alpha, loss.scale);
  return sum_components(rows, weights, r, Jd, alpha, [&](double x) { return loss.rho_of_component(x); });
}

Phi phi_of_batch(const FactorBatch& batch, const double* weights, const double* r, const double* Jd, double alpha) {
  const int m = batch.residual_dim();
  if (batch.has_one_loss()) return phi_of_rows(batch.family(), batch.size() * m, m, weights, r, Jd, alpha);
  Phi sum;
  for (int i = 0; i < batch.size(); ++i) {
    const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(i) * m;
    sum += phi_of_rows(batch.loss(i), m, m, weights + row, r + row, Jd + row, alpha);
  }
  return sum;
}

void weights_of_rows(const FactorBatch& batch, double* weights) {
  for (int i = 0; i < batch.size(); ++i) weights = std::fill_n(weights, batch.residual_dim(), batch.weight(i));
}

}  // namespace holdfast::detail
