// GTSAM's optimizers as back-ends of ours: "gtsam" (Levenberg–Marquardt) and "gtsam-gn" (Gauss–Newton), both with GTSAM's multifrontal Cholesky.
//
//   register_gtsam_backends();
//   make_backend("gtsam")->solve(graph, values);
//
// Our factors in GTSAM's graph (gtsam.hpp), fixed variables as constants in them. cost_tolerance is GTSAM's relativeErrorTol; it has no
// gradient_tolerance. A Gauss–Newton run that ends above its start is a failure.
#pragma once

#include <gtsam/nonlinear/GaussNewtonOptimizer.h>
#include <gtsam/nonlinear/LevenbergMarquardtOptimizer.h>

#include <cmath>
#include <holdfast/adapters/gtsam.hpp>
#include <holdfast/graph/gradient.hpp>
#include <holdfast/solvers/minimizer.hpp>

namespace holdfast {

template <class Optimizer, class Params>
class GtsamBackend final : public Backend {
 public:
  GtsamBackend(std::string name, const Options& chosen) : Backend(chosen), name_(std::move(name)) {}
  std::string name() const override { return name_; }

 protected:
  Summary minimize(const Graph& graph, Values& values) override {
    Progress progress(options, kMaxIterations);
    Summary& summary = progress.summary;
    const Resolved resolved(graph, values);
    if (resolved.tangent_dim() == 0) fail<BadProblem>("every variable that a factor touches is fixed; there is nothing to solve for");
    if (!progress.begin(resolved.cost(graph, values), graph, resolved, values)) return summary;

    const gtsam::NonlinearFactorGraph theirs = detail::to_gtsam(graph, values, true);  // what is constant costs the same everywhere
    gtsam::Values start;
    Values x = values;
    for (const Resolved::Variable& v : resolved.variables()) {
      PoolBase& pool = x.pool(v.pool);
      if (v.offset >= 0) detail::gtsam_slot(pool.type())->insert(start, gtsam_key(v.key), pool.data(v.index));
    }
    Optimizer optimizer(theirs, start, params(progress));
    progress.watch.lap(summary.seconds_setup);
    run(optimizer, progress);
    progress.watch.lap(summary.seconds_solve);
    if (summary.termination == Termination::failed) return summary;

    for (const Resolved::Variable& v : resolved.variables()) {
      PoolBase& pool = x.pool(v.pool);
      if (v.offset >= 0) detail::gtsam_slot(pool.type())->read(optimizer.values(), gtsam_key(v.key), pool.data(v.index));
    }
    summary.cost = resolved.cost(graph, x);
    if (!(summary.cost <= summary.cost_first)) {
      progress.end(Termination::failed, "GTSAM ended above its start");
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
  struct Stop {};

  Params params(Progress& progress) const {
    Params all;
    all.maxIterations = options.max_iterations > 0 ? options.max_iterations : kMaxIterations;
    all.relativeErrorTol = options.cost_tolerance;
    all.absoluteErrorTol = 0;
    all.errorTol = 0;
    all.iterationHook = [&progress](size_t iteration, double, double error) {
      progress.summary.iterations = static_cast<int>(iteration);
      progress.summary.cost = error;
      if (!progress.go_on(std::nan("")) && progress.summary.termination != Termination::iteration_limit) throw Stop();
    };
    return all;
  }

  static void run(Optimizer& optimizer, Progress& progress) {
    try {
      optimizer.optimize();
      progress.summary.iterations = static_cast<int>(optimizer.iterations());
      progress.end(Termination::converged, "GTSAM converged");
      if (optimizer.iterations() >= static_cast<size_t>(optimizer.params().maxIterations))
        progress.end(Termination::iteration_limit, "max_iterations reached");
    } catch (const Stop&) {  // go_on has said why
    } catch (const std::exception& error) {
      progress.end(Termination::failed, "GTSAM failed");
      progress.summary.culprit = error.what();
      progress.summary.cost = progress.summary.cost_first;
    }
  }

  std::string name_;
};

inline void register_gtsam_backends() {
  register_backend("gtsam", [](const Options& options) {
    return std::make_unique<GtsamBackend<gtsam::LevenbergMarquardtOptimizer, gtsam::LevenbergMarquardtParams>>("gtsam", options);
  });
  register_backend("gtsam-gn", [](const Options& options) {
    return std::make_unique<GtsamBackend<gtsam::GaussNewtonOptimizer, gtsam::GaussNewtonParams>>("gtsam-gn", options);
  });
}

}  // namespace holdfast
