#include <algorithm>
#include <cmath>
#include <holdfast/solvers/internal/minimizer.hpp>
#include <holdfast/solvers/irls/internal/newton_system.hpp>
#include <holdfast/solvers/linear/internal/damping.hpp>

namespace holdfast::detail {
namespace {

/// The variables of the free nodes, in the order of elimination.
std::vector<int> variables_in_order(const Symbolic& symbolic, const std::vector<int>& variable) {
  std::vector<int> order;
  for (int node : symbolic.order) order.push_back(variable[node]);
  return order;
}

}  // namespace

NewtonSystem::NewtonSystem(const Graph& graph, const Values& values, int threads)
    : resolved_(graph, values),
      symbolic_(analyze(block_graph(graph, resolved_, variable_))),
      normal_(graph, resolved_, variables_in_order(symbolic_, variable_)),
      cholesky_(std::move(symbolic_), normal_.pattern()),
      pool_(threads) {
  for (std::vector<double>* v : {&diagonal_, &damping_, &rhs_}) v->resize(resolved_.tangent_dim());
}

double NewtonSystem::linearize(const Graph& graph, const Values& values, Curvature curvature) {
  const double cost = normal_.linearize(graph, resolved_, values, curvature, &pool_);
  read_diagonal();
  return cost;
}

double NewtonSystem::linearize_at(const Graph& graph, const std::vector<std::vector<double>>& r, const std::vector<std::vector<double>>& J,
                                  Curvature curvature) {
  const double cost = normal_.linearize_at(graph, r, J, curvature, &pool_);
  read_diagonal();
  return cost;
}

void NewtonSystem::read_diagonal() {
  const BlockPattern& pattern = normal_.pattern();
  for (int i = 0; i < pattern.size(); ++i) {
    const double* block = &normal_.H()[pattern.block_begin[pattern.column_begin[i]]];
    for (int c = 0; c < pattern.dims[i]; ++c) diagonal_[pattern.offsets[i] + c] = block[c * (pattern.dims[i] + 1)];
  }
}

double NewtonSystem::solve_damped(double lambda, std::vector<double>& step) { return solve_damped(lambda, diagonal_, step); }

double NewtonSystem::solve_damped(double lambda, const std::vector<double>& scales, std::vector<double>& step) {
  for (std::size_t i = 0; i < damping_.size(); ++i) damping_[i] = lambda * std::max(scales[i], kLeastDiagonal);
  is_factored_ = cholesky_.factor(normal_.H(), damping_, &pool_);
  if (!is_factored_) return NAN;
  const std::vector<double>& g = gradient();
  for (std::size_t i = 0; i < rhs_.size(); ++i) rhs_[i] = -g[i];
  cholesky_.solve(rhs_, step);
  double predicted = 0;
  for (std::size_t i = 0; i < step.size(); ++i) predicted += 0.5 * step[i] * (damping_[i] * step[i] - g[i]);
  return predicted;
}

bool NewtonSystem::factor_by_blocks(double lambda) {
  damping_ = block_scales();
  for (double& d : damping_) d *= lambda;
  is_factored_ = false;
  for (int i = 0; i < 8 && !is_factored_; ++i) {
    is_factored_ = cholesky_.factor(normal_.H(), damping_, &pool_);
    for (double& d : damping_) d *= 10;
  }
  return is_factored_;
}

std::vector<double> NewtonSystem::block_scales() const {
  const BlockPattern& pattern = normal_.pattern();
  std::vector<double> scales(diagonal_.size());
  const auto begin = diagonal_.begin();
  for (int i = 0; i < pattern.size(); ++i) {
    const int first = pattern.offsets[i], last = pattern.offsets[i + 1];
    std::fill(scales.begin() + first, scales.begin() + last, *std::max_element(begin + first, begin + last));
  }
  const double largest = scales.empty() ? 0 : *std::max_element(scales.begin(), scales.end());
  for (double& s : scales)
    if (s == 0) s = largest > 0 ? largest : 1;
  return scales;
}

std::vector<std::vector<int>> tangent_offsets(const Resolved& resolved) {
  std::vector<std::vector<int>> offsets;
  for (const Resolved::Batch& batch : resolved.batches()) {
    offsets.emplace_back();
    for (int v : batch.variable) offsets.back().push_back(resolved.variables()[v].offset);
  }
  return offsets;
}

void NewtonSystem::retract(const Values& from, double t, const std::vector<double>& step, Values& to) {
  tangent_.resize(step.size());
  to_tangent(step, tangent_);
  for (double& x : tangent_) x *= t;
  resolved_.retract(from, tangent_.data(), to);
}

double NewtonSystem::dot(const std::vector<double>& metric, const std::vector<double>& a, const std::vector<double>& b) const {
  return detail::dot(metric, a, b);
}

double NewtonSystem::gradient_norm() const { return max_norm(gradient()); }

double dot(const std::vector<double>& metric, const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += metric[i] * a[i] * b[i];
  return sum;
}

}  // namespace holdfast::detail
