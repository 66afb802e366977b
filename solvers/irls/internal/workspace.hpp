// What the in-house second-order back-end keeps between solves of one structure. Internal.
#pragma once

#include <holdfast/graph/gradient.hpp>
#include <holdfast/solvers/internal/minimizer.hpp>
#include <holdfast/solvers/irls/irls.hpp>
#include <holdfast/solvers/linear/internal/block_cholesky.hpp>

namespace holdfast {

/// How far a quadratic model is trusted, measured in the metric of diag H. Open at first: a full Newton step.
class TrustRegion {
 public:
  double radius() const { return radius_; }
  void accept(double gain_ratio, double length);
  void reject(double length) { radius_ = 0.5 * length; }

 private:
  double radius_ = std::numeric_limits<double>::infinity();
};

struct Irls::Workspace {
  Resolved resolved;
  std::vector<int> variable;  // of each node of the block graph
  Symbolic symbolic;
  NormalEquations normal;
  BlockCholesky cholesky;
  GradientEvaluator gradients;
  ThreadPool pool;
  TrustRegion region;
  bool bends = false;  // the last step fell short of its model: the residuals are curved here
  Values best, candidate;
  bool may_restart = false;
  std::unique_ptr<Values> other_start;  // where a second descent is to begin
  std::vector<double> damping, diagonal, rhs, step, tangent;
  std::vector<double> newton, steepest, H_steepest;
  double newton_length = 0;               // in the metric of diag H
  double steepest_slope = 0;              // gᵀ steepest; 0: not known of this linearisation
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

  /// `newton` = −(H + λ diag H)⁻¹ g with the least λ that makes the matrix definite; false where none does.
  bool find_newton_step();
  /// Powell's dogleg into `step`: to the minimum along −D⁻¹g, D = diag H, from there to `newton`, cut where it leaves the radius.
  struct Step {
    double predicted;  ///< decrease of the cost that the model predicts
    double length;     ///< in the metric of D
  };
  Step take_dogleg_step(double radius);

  /// Bends the step `tangent` along the curve of the residuals (geodesic acceleration); false where the curve is too strong for that.
  bool accelerate(const Graph& graph);

  void evaluate_linear(const Graph& graph);  ///< r and J at `best`
  void apply_step(const Graph& graph);       ///< tangent from step, Jd from tangent
  void move_along(double alpha);             ///< r and total, by α times the step

 private:
  std::vector<int> variables_in_order() const;
};

}  // namespace holdfast
