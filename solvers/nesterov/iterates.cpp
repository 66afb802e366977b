#include <cmath>
#include <holdfast/solvers/nesterov/internal/iterates.hpp>

namespace holdfast::detail {
namespace {

constexpr double kRounding = 1e-14;      // of the cost: what a comparison of two costs can tell
constexpr double kMostLipschitz = 1e30;  // in the metric P, where 2 bounds any graph of pairwise linear factors

}  // namespace

Iterates::Iterates(const Resolved& resolved, const Values& values)
    : x_(values), y_(values), next_(values), step_(resolved.tangent_dim()), move_(resolved.tangent_dim()) {}

double Iterates::backtrack(const Graph& graph, const Resolved& resolved, double cost_y, const std::vector<double>& direction, double norm2,
                           ThreadPool* pool) {
  for (; L_ < kMostLipschitz; L_ *= 2) {
    for (std::size_t i = 0; i < step_.size(); ++i) step_[i] = -direction[i] / L_;
    resolved.retract(y_, step_.data(), next_);
    const double cost = resolved.cost(graph, next_, pool);
    if (cost <= cost_y - norm2 / (2 * L_) + kRounding * std::abs(cost_y)) return cost;
  }
  return NAN;
}

double Iterates::extrapolate(const Resolved& resolved, const std::vector<double>& g, double beta) {
  resolved.local(x_, next_, move_.data());
  double uphill = 0;
  for (std::size_t i = 0; i < move_.size(); ++i) {
    uphill += g[i] * move_[i];
    move_[i] *= beta;
  }
  std::swap(x_, next_);
  resolved.retract(x_, move_.data(), y_);
  return uphill;
}

void Iterates::restart() {
  y_.assign(x_);
  t_ = L_ = 1;
  plain_ = true;
}

void Iterates::accept(const Resolved& resolved, const std::vector<double>& g) {
  const double t_next = (1 + std::sqrt(1 + 4 * t_ * t_)) / 2;
  const bool uphill = extrapolate(resolved, g, (t_ - 1) / t_next) > 0;
  plain_ = t_ == 1 || uphill;
  if (uphill) y_.assign(x_);
  t_ = uphill ? 1 : t_next;
}

}  // namespace holdfast::detail
