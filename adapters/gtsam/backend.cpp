#include <gtsam/nonlinear/GaussNewtonOptimizer.h>
#include <gtsam/nonlinear/LevenbergMarquardtOptimizer.h>

#include <cmath>
#include <holdfast/adapters/gtsam/backend.hpp>
#include <holdfast/adapters/gtsam/gtsam.hpp>
#include <holdfast/solvers/internal/foreign_backend.hpp>
#include <holdfast/solvers/table.hpp>

namespace holdfast {
namespace {

template <class Optimizer, class Params>
class GtsamBackend final : public ForeignBackend {
 public:
  using ForeignBackend::ForeignBackend;

 protected:
  void optimize(const Graph& graph, const Resolved& resolved, Values& x, Progress& progress) override {
    gtsam::NonlinearFactorGraph theirs;
    for (const auto& batch : graph.batches())
      for (int i = 0; i < batch->size(); ++i)
        if (const auto factor = detail::gtsam_factor(Term(*batch, i), batch->keys(i), graph, x))
          theirs.push_back(factor);  // else: a constant cost
    gtsam::Values start;
    for_each_free(resolved, x, [&](gtsam::Key key, PoolBase& pool, int i) { detail::gtsam_slot(pool)->insert(start, key, pool.data(i)); });
    Optimizer optimizer(theirs, start, params(progress));
    progress.watch.lap(progress.summary.seconds_setup);
    run(optimizer, progress);
    progress.watch.lap(progress.summary.seconds_solve);
    for_each_free(resolved, x,
                  [&](gtsam::Key key, PoolBase& pool, int i) { detail::gtsam_slot(pool)->read(optimizer.values(), key, pool.data(i)); });
  }

 private:
  struct Stop {};

  template <class Fn>
  static void for_each_free(const Resolved& resolved, Values& x, const Fn& fn) {
    for (const Resolved::Variable& v : resolved.variables())
      if (v.offset >= 0) fn(gtsam_key(v.key), x.pool(v.pool), v.index);
  }

  Params params(Progress& progress) {
    Params all;
    all.maxIterations = iteration_limit();
    all.relativeErrorTol = options.cost_tolerance;
    all.absoluteErrorTol = 0;
    all.errorTol = 0;
    all.iterationHook = [this, &progress](size_t iteration, double before, double error) {
      rose_ = error > before;
      progress.summary.iterations = static_cast<int>(iteration);
      progress.summary.cost = error;
      if (!progress.go_on(std::nan("")) && progress.summary.termination != Termination::iteration_limit) throw Stop();
    };
    return all;
  }

  void run(Optimizer& optimizer, Progress& progress) {
    rose_ = false;
    try {
      optimizer.optimize();
      progress.summary.iterations = static_cast<int>(optimizer.iterations());
      progress.end(Termination::converged, "GTSAM converged");
      if (rose_) progress.end(Termination::stopped, "GTSAM stopped where its error rose");
      if (optimizer.iterations() >= static_cast<size_t>(optimizer.params().maxIterations))
        progress.end(Termination::iteration_limit, "max_iterations reached");
    } catch (const Stop&) {  // go_on has said why
    } catch (const std::exception& error) {
      progress.end(Termination::failed, "GTSAM failed");
      progress.summary.culprit = error.what();
    }
  }

  bool rose_ = false;  ///< in the last iteration: Gauss–Newton may, and GTSAM calls that the end
};

}  // namespace

void register_gtsam_backends() {
  register_backend("gtsam-lm", [](const Options& options) {
    return std::make_unique<GtsamBackend<gtsam::LevenbergMarquardtOptimizer, gtsam::LevenbergMarquardtParams>>("gtsam-lm", options);
  });
  register_backend("gtsam-gn", [](const Options& options) {
    return std::make_unique<GtsamBackend<gtsam::GaussNewtonOptimizer, gtsam::GaussNewtonParams>>("gtsam-gn", options);
  });
}

}  // namespace holdfast
