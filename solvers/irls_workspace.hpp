// What the in-house second-order back-end keeps between solves of one structure. Internal.
#pragma once

#include <holdfast/graph/gradient.hpp>
#include <holdfast/solvers/block_cholesky.hpp>
#include <holdfast/solvers/irls.hpp>
#include <holdfast/solvers/minimizer.hpp>

namespace holdfast {

/// λ, as Nielsen moves it: down by how well the model predicted, up faster with every failure in a row.
class Damping {
 public:
  double lambda() const { return lambda_; }
  void accept(double gain_ratio);
  /// False when there is nothing left to try.
  bool reject();

 private:
  double lambda_ = 0;
  double growth_ = 4;
};

struct Irls::Workspace {
  Resolved resolved;
  std::vector<int> variable;  // of each node of the block graph
  Symbolic symbolic;
  NormalEquations normal;
  BlockCholesky cholesky;
  GradientEvaluator gradients;
  ThreadPool pool;
  Damping damper;
  bool bends = false;  // the last step fell short of its model: the residuals are curved here
  Values best, candidate;
  bool may_restart = false;
  std::unique_ptr<Values> other_start;  // where a second descent is to begin
  std::vector<double> damping, diagonal, rhs, step, tangent;
  std::vector<std::vector<int>> offsets;  // by batch: where each variable's part of a tangent begins
  std::vector<double> bend, acceleration;
  // Of linear problems only: residuals, Jacobians, J δ and the weights of the rows, of each batch.
  std::vector<std::vector<double>> r, J, Jd, row_weights;
  std::vector<double> total;  // the way from the start, in the tangent

  Workspace(const Graph& graph, const Values& values, int threads);

  /// (H + λ diag H) δ = −g into `step`; returns the decrease of the cost that the quadratic model predicts, or NaN where the
  /// matrix is not positive definite.
  double solve_damped(double lambda);
  void read_diagonal();

  /// Bends the step `tangent` along the curve of the residuals (geodesic acceleration); false where the curve is too strong for that.
  bool accelerate(const Graph& graph);

  void evaluate_linear(const Graph& graph);  ///< r and J at `best`
  void apply_step(const Graph& graph);       ///< tangent from step, Jd from tangent
  void move_along(double alpha);             ///< r and total, by α times the step

 private:
  std::vector<int> variables_in_order() const;
};

}  // namespace holdfast
