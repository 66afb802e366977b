#include <ceres/ceres.h>

#include <holdfast/solvers/ceres/ceres.hpp>
#include <holdfast/solvers/ceres/internal/cost.hpp>
#include <holdfast/solvers/ceres/internal/loss.hpp>
#include <holdfast/solvers/ceres/internal/manifold.hpp>
#include <holdfast/solvers/detail/fold.hpp>
#include <holdfast/solvers/internal/foreign_backend.hpp>

namespace holdfast {
namespace {

constexpr int kDenseUnknowns = 30;

// A variable's memory is its ambient coordinates. Jacobians come with respect to the tangent, so the manifold pretends that the
// first `dim` ambient columns are the tangent: [J 0] · [I; 0] = J, which spares two products a block.
class VariableGeometry {
 public:
  explicit VariableGeometry(const PoolBase& pool) : pool_(&pool) {}
  int ambient() const { return pool_->ambient(); }
  int dim() const { return pool_->dim(); }
  void plus(const double* x, const double* delta, double* out) const { pool_->retract_ambient(x, delta, out); }
  void minus(const double* y, const double* x, double* delta) const { pool_->local_ambient(x, y, delta); }
  void plus_jacobian(const double*, double* P) const { Eigen::Map<Eigen::MatrixXd>(P, ambient(), dim()).setIdentity(); }
  void minus_jacobian(const double*, double* M) const { Eigen::Map<Eigen::MatrixXd>(M, dim(), ambient()).setIdentity(); }

 private:
  const PoolBase* pool_;
};

class FactorCost final : public CeresCost {
 public:
  FactorCost(const FactorBatch& batch, int i, const std::vector<int>& ambient, bool folded)
      : CeresCost(batch.residual_dim(), batch.total_dim(), folded), batch_(batch), i_(i) {
    *mutable_parameter_block_sizes() = ambient;
  }

 private:
  int scratch_size() const override { return 0; }
  void evaluate(const double* const* blocks, double* residuals, double* J, Scratch&) const override {
    batch_.evaluate_at(i_, blocks, residuals, J);
  }
  void distribute(const double* J, const double* const*, double** jacobians, Scratch&) const override {
    const int m = batch_.residual_dim();
    for (int k = 0; k < batch_.arity(); ++k) {
      const int dim = batch_.dims()[k], ambient = parameter_block_sizes()[k];
      if (jacobians[k] != nullptr)
        for (int row = 0; row < m; ++row)
          for (int c = 0; c < ambient; ++c) jacobians[k][row * ambient + c] = c < dim ? J[c * m + row] : 0;
      J += m * dim;
    }
  }
  const Loss& loss() const override { return batch_.loss(i_); }
  double weight() const override { return batch_.weight(i_); }

  const FactorBatch& batch_;
  int i_;
};

// Hands each iteration to our progress callback.
class Callback final : public ceres::IterationCallback {
 public:
  explicit Callback(Progress& progress) : progress_(progress) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& iteration) override {
    // Of a step that is refused Ceres says the cost it would have had.
    if (iteration.iteration == 0 || iteration.cost < progress_.summary.cost) progress_.summary.cost = iteration.cost;
    progress_.summary.iterations = iteration.iteration;
    return progress_.go_on(iteration.gradient_max_norm) ? ceres::SOLVER_CONTINUE : ceres::SOLVER_TERMINATE_SUCCESSFULLY;
  }

 private:
  Progress& progress_;
};

class CeresBackend final : public ForeignBackend {
 public:
  CeresBackend(const CeresVariant& variant, const Options& chosen) : ForeignBackend(variant.name, chosen), variant_(variant) {}

 protected:
  void optimize(const Graph& graph, const Resolved& resolved, Values& x, Progress& progress) override;

 private:
  ceres::Solver::Options solver_options(const Resolved& resolved) const;

  CeresVariant variant_;
};

void add_variables(const Resolved& resolved, Values& x, ceres::Problem& problem) {
  for (const Resolved::Variable& v : resolved.variables()) {
    PoolBase& pool = x.pool(v.pool);
    double* block = pool.data(v.index);
    problem.AddParameterBlock(block, pool.ambient());
    if (pool.ambient() != pool.dim()) problem.SetManifold(block, new CeresManifold<VariableGeometry>(VariableGeometry(pool)));
    if (v.offset < 0) problem.SetParameterBlockConstant(block);
  }
}

void build(const Graph& graph, const Resolved& resolved, Values& x, ceres::Problem& problem) {
  add_variables(resolved, x, problem);
  for (std::size_t b = 0; b < graph.batches().size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    const bool folded = must_fold(batch.family(), batch.residual_dim());
    const std::vector<int>& variable = resolved.batches()[b].variable;
    std::vector<double*> blocks(batch.arity());
    std::vector<int> ambient(batch.arity());
    for (int i = 0; i < batch.size(); ++i) {
      for (int k = 0; k < batch.arity(); ++k) {
        const Resolved::Variable& v = resolved.variables()[variable[static_cast<std::size_t>(i) * batch.arity() + k]];
        blocks[k] = x.pool(v.pool).data(v.index);
        ambient[k] = x.pool(v.pool).ambient();
      }
      const bool plain = folded || (batch.family().kind == Loss::Kind::Squared && batch.weight(i) == 1);
      problem.AddResidualBlock(new FactorCost(batch, i, ambient, folded),
                               plain ? nullptr : new CeresLoss(batch.loss(i), batch.weight(i), batch.residual_dim()), blocks);
    }
  }
}

ceres::Solver::Options CeresBackend::solver_options(const Resolved& resolved) const {
  ceres::Solver::Options o;
  o.logging_type = ceres::SILENT;
  o.linear_solver_type = resolved.tangent_dim() <= kDenseUnknowns ? ceres::DENSE_NORMAL_CHOLESKY : ceres::SPARSE_NORMAL_CHOLESKY;
  o.num_threads = options.threads;
  o.max_num_iterations = iteration_limit();
  o.function_tolerance = options.cost_tolerance;
  o.gradient_tolerance = options.gradient_tolerance;
  o.parameter_tolerance = 1e-15;  // the rules are ours: cost and gradient
  o.max_solver_time_in_seconds = std::min(options.time_limit, 1e9);
  o.initial_trust_region_radius = variant_.trust_region_radius;
  o.max_trust_region_radius = 1e32;
  o.max_num_consecutive_invalid_steps = 100;  // from 1e32 down to where a singular H becomes definite
  if (variant_.dogleg) o.trust_region_strategy_type = ceres::DOGLEG;
  return o;
}

void read_outcome(const ceres::Solver::Summary& outcome, Progress& progress) {
  Summary& summary = progress.summary;
  summary.seconds_linearize = outcome.residual_evaluation_time_in_seconds + outcome.jacobian_evaluation_time_in_seconds;
  summary.seconds_solve = outcome.linear_solver_time_in_seconds;
  summary.iterations = std::max(0, static_cast<int>(outcome.iterations.size()) - 1);
  switch (outcome.termination_type) {
    case ceres::CONVERGENCE:
      return progress.end(Termination::converged, "Ceres converged");
    case ceres::NO_CONVERGENCE:
      return outcome.message.find("solver time") != std::string::npos
                 ? progress.end(Termination::time_limit, "time_limit reached")
                 : progress.end(Termination::iteration_limit, "max_iterations reached");
    case ceres::USER_SUCCESS:
      return;  // Callback has said why
    default:
      summary.culprit = outcome.message;
      return progress.end(Termination::failed, "Ceres failed");
  }
}

void CeresBackend::optimize(const Graph& graph, const Resolved& resolved, Values& x, Progress& progress) {
  ceres::Problem problem;
  build(graph, resolved, x, problem);
  ceres::Solver::Options solver = solver_options(resolved);
  Callback callback(progress);
  solver.callbacks.push_back(&callback);
  progress.watch.lap(progress.summary.seconds_setup);

  ceres::Solver::Summary outcome;
  ceres::Solve(solver, &problem, &outcome);
  read_outcome(outcome, progress);
}

}  // namespace

CeresEvaluation evaluate_with_ceres(const Graph& graph, const Values& values) {
  const Resolved resolved(graph, values);
  Values x = values;
  ceres::Problem problem;
  build(graph, resolved, x, problem);
  ceres::Problem::EvaluateOptions options;
  for (const Resolved::Variable& v : resolved.variables())
    if (v.offset >= 0) options.parameter_blocks.push_back(x.pool(v.pool).data(v.index));
  CeresEvaluation evaluation;
  problem.Evaluate(options, &evaluation.cost, nullptr, &evaluation.gradient, nullptr);
  return evaluation;
}

std::unique_ptr<Backend> make_ceres(const CeresVariant& variant, const Options& options) {
  return std::make_unique<CeresBackend>(variant, options);
}

}  // namespace holdfast
