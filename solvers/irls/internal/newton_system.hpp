// The linearised problem of one structure, (H + λ diag H) δ = −g, with its ordering and factorisation. Internal.
#pragma once

#include <holdfast/solvers/irls/internal/line_search.hpp>
#include <holdfast/solvers/irls/internal/quadratic_model.hpp>
#include <holdfast/solvers/linear/internal/block_cholesky.hpp>

namespace holdfast::detail {

class NewtonSystem final : public QuadraticModel {
 public:
  NewtonSystem(const Graph& graph, const Values& values, int threads);

  bool serves(const Graph& graph, const Values& values, int threads) const {
    return resolved_.matches(graph, values) && pool_.threads() == threads;
  }
  const Resolved& resolved() const { return resolved_; }
  ThreadPool& pool() { return pool_; }
  std::size_t size() const override { return diagonal_.size(); }

  double linearize(const Graph& graph, const Values& values, Curvature curvature) override;
  /// The same where the residuals and Jacobians of each batch are known.
  double linearize_at(const Graph& graph, const std::vector<std::vector<double>>& r, const std::vector<std::vector<double>>& J,
                      Curvature curvature);
  const std::vector<double>& gradient() const override { return normal_.gradient(); }  ///< g, in elimination order, as all vectors here
  const std::vector<double>& diagonal() const override { return diagonal_; }
  void multiply(const std::vector<double>& x, std::vector<double>& y) const override { normal_.multiply(x, y); }

  /// By one factorisation.
  double solve_damped(double lambda, std::vector<double>& step) override;
  double solve_damped(double lambda, const std::vector<double>& scales, std::vector<double>& step) override;
  double cost(const Graph& graph, const Values& values) override { return resolved_.cost(graph, values, &pool_); }
  void retract(const Values& from, double t, const std::vector<double>& step, Values& to) override;
  double dot(const std::vector<double>& a, const std::vector<double>& b) const override { return detail::dot(a, b); }
  double dot(const std::vector<double>& metric, const std::vector<double>& a, const std::vector<double>& b) const override;
  std::string first_non_finite(const Graph& graph, const Values& values) const override {
    return resolved_.first_non_finite(graph, values).text;
  }
  double gradient_norm() const override;
  /// Factors H + λ D, D the largest diagonal entry of each scalar's variable: it bounds M⁻¹ where a direction of a variable has no
  /// curvature. False where no λ up to 1e8 times the given one makes it definite.
  bool factor_by_blocks(double lambda);
  /// By scalar row: the largest diagonal entry of the variable it belongs to; where that is 0, the largest of all; where that is, 1.
  std::vector<double> block_scales() const;
  /// True where the last factorisation went well.
  bool is_factored() const { return is_factored_; }
  /// x = M⁻¹ b with what was factored last.
  void solve_again(const std::vector<double>& b, std::vector<double>& x) { cholesky_.solve(b, x); }

  /// Between the elimination order and Resolved's tangent.
  void to_tangent(const std::vector<double>& ordered, std::vector<double>& tangent) const {
    normal_.to_tangent(resolved_, ordered.data(), tangent.data());
  }
  void from_tangent(const std::vector<double>& tangent, std::vector<double>& ordered) const {
    normal_.from_tangent(resolved_, tangent.data(), ordered.data());
  }

 private:
  void read_diagonal();

  Resolved resolved_;
  std::vector<int> variable_;  // of each node of the block graph
  Symbolic symbolic_;
  NormalEquations normal_;
  BlockCholesky cholesky_;
  ThreadPool pool_;
  std::vector<double> diagonal_, damping_, rhs_, tangent_;
  bool is_factored_ = false;
};

/// Where each variable's part of a tangent begins, by batch, for every variable of every factor; −1: fixed.
std::vector<std::vector<int>> tangent_offsets(const Resolved& resolved);

/// Σ metric_i a_i b_i.
double dot(const std::vector<double>& metric, const std::vector<double>& a, const std::vector<double>& b);

}  // namespace holdfast::detail
