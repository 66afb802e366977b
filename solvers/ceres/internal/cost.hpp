// A residual of ours as a ceres::CostFunction: what our back-end and the adapter share. They differ in where the variables lie.
#pragma once

#include <ceres/cost_function.h>

#include <cmath>
#include <holdfast/graph/loss.hpp>
#include <holdfast/solvers/detail/fold.hpp>
#include <utility>
#include <vector>

namespace holdfast {

/// Doubles on the stack where they fit.
class Scratch {
 public:
  explicit Scratch(int size) : large_(size > kStack ? static_cast<std::size_t>(size) : 0), next_(large_.empty() ? local_ : large_.data()) {}
  double* take(int n) { return std::exchange(next_, next_ + n); }

 private:
  static constexpr int kStack = 512;
  double local_[kStack];
  std::vector<double> large_;
  double* next_;
};

/// Evaluates, refuses what is not finite (Ceres then shortens its step), folds the loss in where Ceres does not know it, and hands the
/// Jacobian to Ceres' blocks. J is by the tangents of our variables side by side, in columns.
class CeresCost : public ceres::CostFunction {
 public:
  bool Evaluate(const double* const* blocks, double* residuals, double** jacobians) const final {
    const int m = num_residuals();
    Scratch scratch(m * total_dim_ + scratch_size());
    double* J = jacobians == nullptr ? nullptr : scratch.take(m * total_dim_);
    evaluate(blocks, residuals, J, scratch);
    for (int c = 0; c < m; ++c)
      if (!std::isfinite(residuals[c])) return false;
    if (folded_) fold(loss(), weight(), m, total_dim_, residuals, J);
    if (J != nullptr) distribute(J, blocks, jacobians, scratch);
    return true;
  }

 protected:
  CeresCost(int residual_dim, int total_dim, bool folded) : total_dim_(total_dim), folded_(folded) { set_num_residuals(residual_dim); }

  /// How many doubles evaluate() and distribute() take from the scratch.
  virtual int scratch_size() const = 0;
  virtual void evaluate(const double* const* blocks, double* residuals, double* J, Scratch& scratch) const = 0;
  /// Jacobians of the blocks, by rows; null for a block that is constant.
  virtual void distribute(const double* J, const double* const* blocks, double** jacobians, Scratch& scratch) const = 0;
  virtual const Loss& loss() const = 0;
  virtual double weight() const = 0;

 private:
  int total_dim_;
  bool folded_;
};

}  // namespace holdfast
