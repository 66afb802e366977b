// g2o's optimizers as back-ends of ours: "g2o" (Gauss–Newton) and "g2o-lm" (Levenberg–Marquardt), with CHOLMOD where g2o has it
// (HOLDFAST_G2O_CHOLMOD), else Eigen's sparse Cholesky.
//
//   register_g2o_backends();
//   make_backend("g2o")->solve(graph, values);
//
// Blocks of fixed size where all free variables are of 3 or of 6 dimensions; edges of fixed size between poses and for ranges. The stopping rule
// is cost_tolerance; g2o's Gauss–Newton has no safeguard: a run that ends above its start is a failure.
#pragma once

#include <g2o/core/block_solver.h>
#include <g2o/core/optimization_algorithm_gauss_newton.h>
#include <g2o/core/optimization_algorithm_levenberg.h>
#include <g2o/core/sparse_optimizer.h>
#ifdef HOLDFAST_G2O_CHOLMOD
#include <g2o/solvers/cholmod/linear_solver_cholmod.h>
#else
#include <g2o/solvers/eigen/linear_solver_eigen.h>
#endif

#include <cmath>
#include <holdfast/adapters/g2o.hpp>
#include <holdfast/graph/gradient.hpp>
#include <holdfast/solvers/minimizer.hpp>

namespace holdfast {
namespace detail {

/// Stops the optimizer by our rules after an iteration.
class G2oProgress final : public g2o::HyperGraphAction {
 public:
  G2oProgress(g2o::SparseOptimizer& optimizer, Progress& progress) : optimizer_(optimizer), progress_(progress) {
    optimizer_.setForceStopFlag(&stop_);
    optimizer_.addPostIterationAction(this);
  }
  ~G2oProgress() override { optimizer_.removePostIterationAction(this); }
  g2o::HyperGraphAction* operator()(const g2o::HyperGraph*, Parameters*) override {
    optimizer_.computeActiveErrors();
    const double before = progress_.summary.cost, cost = 0.5 * optimizer_.activeRobustChi2();
    ++progress_.summary.iterations;
    progress_.summary.cost = cost;
    const bool done = !std::isfinite(cost) || (cost <= before && progress_.decrease_is_small(before, cost));
    stop_ = done || !progress_.go_on(std::nan(""));
    return this;
  }
  bool stopped() const { return stop_; }

 private:
  g2o::SparseOptimizer& optimizer_;
  Progress& progress_;
  bool stop_ = false;
};

template <int P>
std::unique_ptr<g2o::Solver> g2o_solver() {
  using Blocks = g2o::BlockSolver<g2o::BlockSolverTraits<P, P>>;
#ifdef HOLDFAST_G2O_CHOLMOD
  using Linear = g2o::LinearSolverCholmod<typename Blocks::PoseMatrixType>;
#else
  using Linear = g2o::LinearSolverEigen<typename Blocks::PoseMatrixType>;
#endif
  auto linear = std::make_unique<Linear>();
  linear->setBlockOrdering(true);
  return std::make_unique<Blocks>(std::move(linear));
}

/// An edge of fixed size for what races are made of, else one of any size.
inline g2o::OptimizableGraph::Edge* g2o_edge_of(const FactorBatch& batch, int i) {
  G2oTerm term{Term(batch, i), {}};
  for (const std::type_index& type : batch.types()) term.slots.push_back(g2o_slot(type));
  using namespace g2o;
  const auto is = [&](int m, std::type_index a, std::type_index b) {
    return batch.residual_dim() == m && batch.arity() == 2 && batch.types()[0] == a && batch.types()[1] == b;
  };
  if (is(3, typeid(Pose2), typeid(Pose2))) return new G2oEdge<3, VertexSE2, VertexSE2>(std::move(term));
  if (is(6, typeid(Pose3), typeid(Pose3))) return new G2oEdge<6, VertexSE3, VertexSE3>(std::move(term));
  if (is(1, typeid(Pose2), typeid(Point2))) return new G2oEdge<1, VertexSE2, VertexPointXY>(std::move(term));
  if (is(1, typeid(Pose3), typeid(Point3))) return new G2oEdge<1, VertexSE3, VertexPointXYZ>(std::move(term));
  if (is(1, typeid(Pose2), typeid(Pose2))) return new G2oEdge<1, VertexSE2, VertexSE2>(std::move(term));
  if (is(2, typeid(Pose2), typeid(Point2))) return new G2oEdge<2, VertexSE2, VertexPointXY>(std::move(term));
  return new G2oAnyEdge(std::move(term));
}

}  // namespace detail

class G2oBackend final : public Backend {
 public:
  G2oBackend(std::string name, bool levenberg, const Options& chosen) : Backend(chosen), name_(std::move(name)), levenberg_(levenberg) {}
  std::string name() const override { return name_; }

 protected:
  Summary minimize(const Graph& graph, Values& values) override {
    Progress progress(options, kMaxIterations);
    Summary& summary = progress.summary;
    const Resolved resolved(graph, values);
    if (resolved.tangent_dim() == 0) fail<BadProblem>("every variable that a factor touches is fixed; there is nothing to solve for");
    if (!progress.begin(resolved.cost(graph, values), graph, resolved, values)) return summary;

    Values x = values;
    g2o::SparseOptimizer optimizer;
    optimizer.setAlgorithm(algorithm(resolved));
    build(graph, resolved, x, optimizer);
    optimizer.initializeOptimization();
    progress.watch.lap(summary.seconds_setup);
    run(optimizer, progress);
    progress.watch.lap(summary.seconds_solve);

    for (std::size_t v = 0; v < resolved.variables().size(); ++v) {
      const Resolved::Variable& variable = resolved.variables()[v];
      PoolBase& pool = x.pool(variable.pool);
      if (variable.offset >= 0) detail::g2o_slot(pool.type())->read(*optimizer.vertex(static_cast<int>(v)), pool.data(variable.index));
    }
    summary.cost = resolved.cost(graph, x);
    if (!(summary.cost <= summary.cost_first)) {
      progress.end(Termination::failed, "g2o ended above its start");
      summary.cost = summary.cost_first;
      return summary;
    }
    std::vector<double> gradient;
    GradientEvaluator evaluate(graph);
    evaluate(graph, resolved, x, gradient);
    summary.gradient_norm = max_norm(gradient);
    values.assign(x);
    return summary;
  }

 private:
  static constexpr int kMaxIterations = 1000;

  g2o::OptimizationAlgorithm* algorithm(const Resolved& resolved) const {
    int dim = 0;
    for (const Resolved::Variable& v : resolved.variables())
      if (v.offset >= 0) dim = dim == 0 || dim == v.dim ? v.dim : -1;
    auto solver = dim == 3 ? detail::g2o_solver<3>() : dim == 6 ? detail::g2o_solver<6>() : detail::g2o_solver<Eigen::Dynamic>();
    if (levenberg_) return new g2o::OptimizationAlgorithmLevenberg(std::move(solver));
    return new g2o::OptimizationAlgorithmGaussNewton(std::move(solver));
  }

  static void build(const Graph& graph, const Resolved& resolved, Values& x, g2o::SparseOptimizer& optimizer) {
    for (std::size_t v = 0; v < resolved.variables().size(); ++v) {
      const Resolved::Variable& variable = resolved.variables()[v];
      PoolBase& pool = x.pool(variable.pool);
      auto* vertex = detail::g2o_slot(pool.type())->make(pool.data(variable.index));
      vertex->setId(static_cast<int>(v));
      vertex->setFixed(variable.offset < 0);
      optimizer.addVertex(vertex);
    }
    for (std::size_t b = 0; b < graph.batches().size(); ++b) {
      const FactorBatch& batch = *graph.batches()[b];
      for (int i = 0; i < batch.size(); ++i) {
        auto* edge = detail::g2o_edge_of(batch, i);
        for (int k = 0; k < batch.arity(); ++k)
          edge->setVertex(k, optimizer.vertex(resolved.batches()[b].variable[static_cast<std::size_t>(i) * batch.arity() + k]));
        optimizer.addEdge(edge);
      }
    }
  }

  void run(g2o::SparseOptimizer& optimizer, Progress& progress) const {
    const int limit = options.max_iterations > 0 ? options.max_iterations : kMaxIterations;
    detail::G2oProgress action(optimizer, progress);
    optimizer.optimize(limit);
    if (!action.stopped() || progress.summary.rule == std::string()) progress.end(Termination::converged, "g2o found no better step");
  }

  std::string name_;
  bool levenberg_;
};

inline void register_g2o_backends() {
  register_backend("g2o", [](const Options& options) { return std::make_unique<G2oBackend>("g2o", false, options); });
  register_backend("g2o-lm", [](const Options& options) { return std::make_unique<G2oBackend>("g2o-lm", true, options); });
}

}  // namespace holdfast
