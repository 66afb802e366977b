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
#include <holdfast/adapters/g2o/backend.hpp>
#include <holdfast/adapters/g2o/g2o.hpp>
#include <holdfast/solvers/internal/foreign_backend.hpp>
#include <holdfast/solvers/table.hpp>

namespace holdfast {
namespace {

using detail::G2oTerm, detail::g2o_slot, detail::host_term;

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
    if (!std::isfinite(cost)) progress_.end(Termination::failed, "g2o's cost is not finite");
    stop_ = !std::isfinite(cost) || (cost <= before && progress_.decrease_is_small(before, cost)) || !progress_.go_on(std::nan(""));
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
g2o::OptimizableGraph::Edge* g2o_edge_of(const FactorBatch& batch, int i) {
  G2oTerm term(host_term<detail::G2oSlot, detail::G2oSlotOf>(Term(batch, i)));
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

class G2oBackend final : public ForeignBackend {
 public:
  G2oBackend(std::string name, bool levenberg, const Options& chosen) : ForeignBackend(std::move(name), chosen), levenberg_(levenberg) {}

 protected:
  void optimize(const Graph& graph, const Resolved& resolved, Values& x, Progress& progress) override {
    g2o::SparseOptimizer optimizer;
    optimizer.setAlgorithm(algorithm(resolved));
    build(graph, resolved, x, optimizer);
    optimizer.initializeOptimization();
    progress.watch.lap(progress.summary.seconds_setup);
    run(optimizer, progress);
    progress.watch.lap(progress.summary.seconds_solve);
    for (std::size_t v = 0; v < resolved.variables().size(); ++v) {
      const Resolved::Variable& variable = resolved.variables()[v];
      PoolBase& pool = x.pool(variable.pool);
      if (variable.offset >= 0) g2o_slot(pool)->read(*optimizer.vertex(static_cast<int>(v)), pool.data(variable.index));
    }
  }

 private:
  g2o::OptimizationAlgorithm* algorithm(const Resolved& resolved) const {
    int dim = 0;
    for (const Resolved::Variable& v : resolved.variables())
      if (v.offset >= 0) dim = dim == 0 || dim == v.dim ? v.dim : -1;
    auto solver = dim == 3 ? g2o_solver<3>() : dim == 6 ? g2o_solver<6>() : g2o_solver<Eigen::Dynamic>();
    if (levenberg_) return new g2o::OptimizationAlgorithmLevenberg(std::move(solver));
    return new g2o::OptimizationAlgorithmGaussNewton(std::move(solver));
  }

  static void build(const Graph& graph, const Resolved& resolved, Values& x, g2o::SparseOptimizer& optimizer) {
    for (std::size_t v = 0; v < resolved.variables().size(); ++v) {
      const Resolved::Variable& variable = resolved.variables()[v];
      PoolBase& pool = x.pool(variable.pool);
      auto* vertex = g2o_slot(pool)->make(pool.data(variable.index));
      vertex->setId(static_cast<int>(v));
      vertex->setFixed(variable.offset < 0);
      optimizer.addVertex(vertex);
    }
    for (std::size_t b = 0; b < graph.batches().size(); ++b) {
      const FactorBatch& batch = *graph.batches()[b];
      for (int i = 0; i < batch.size(); ++i) {
        auto* edge = g2o_edge_of(batch, i);
        for (int k = 0; k < batch.arity(); ++k)
          edge->setVertex(k, optimizer.vertex(resolved.batches()[b].variable[static_cast<std::size_t>(i) * batch.arity() + k]));
        optimizer.addEdge(edge);
      }
    }
  }

  void run(g2o::SparseOptimizer& optimizer, Progress& progress) const {
    G2oProgress action(optimizer, progress);
    const bool solved = optimizer.optimize(iteration_limit()) > 0;
    if (!action.stopped())
      progress.end(solved ? Termination::converged : Termination::failed,
                   solved ? "g2o found no better step" : "g2o's linear solver failed");
  }

  bool levenberg_;
};

}  // namespace

void register_g2o_backends() {
  register_backend("g2o", [](const Options& options) { return std::make_unique<G2oBackend>("g2o", false, options); });
  register_backend("g2o-lm", [](const Options& options) { return std::make_unique<G2oBackend>("g2o-lm", true, options); });
}

}  // namespace holdfast
