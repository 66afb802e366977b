#include <algorithm>
#include <cmath>
#include <holdfast/solvers/distributed/internal/dogleg_descent.hpp>

namespace holdfast::detail {
namespace {

constexpr double kRounding = 1e-14;  // of the cost: a predicted decrease below this cannot be measured
constexpr int kMostShrinks = 50;

class Descent {
 public:
  Descent(const Graph& graph, QuadraticModel& system, Values& values, Progress& progress)
      : graph_(graph), system_(system), best_(values), candidate_(values), progress_(progress), dogleg_(system) {}

  void run() {
    Summary& summary = progress_.summary;
    const double first = linearize();
    if (!progress_.begin(first)) {
      summary.culprit = system_.first_non_finite(graph_, best_);
      return;
    }
    double gradient_norm = system_.gradient_norm();
    while (!progress_.gradient_is_flat(gradient_norm) && progress_.go_on(gradient_norm)) {
      ++summary.iterations;
      const double before = summary.cost;
      bool is_full = false;
      if (!step(gradient_norm, is_full)) break;
      linearize();
      gradient_norm = system_.gradient_norm();
      if (is_full && progress_.decrease_is_small(before, summary.cost)) break;
    }
    summary.gradient_norm = gradient_norm;
  }

 private:
  double linearize() {
    const double cost = system_.linearize(graph_, best_, Curvature::irls);
    progress_.watch.lap(progress_.summary.seconds_linearize);
    return cost;
  }

  /// Steps of one factorisation, shorter and shorter, until one lowers the cost; false where the descent is over.
  bool step(double gradient_norm, bool& is_full) {
    if (!dogleg_.begin(system_)) {
      progress_.end(Termination::failed, "the normal equations are not positive definite under any damping");
      return false;
    }
    for (int shrinks = 0; shrinks <= kMostShrinks; ++shrinks) {
      const Dogleg::Step step = dogleg_.take(system_, region_.radius(), step_);
      progress_.watch.lap(progress_.summary.seconds_solve);
      is_full = step.is_full;
      system_.retract(best_, 1, step_, candidate_);
      const double cost = system_.cost(graph_, candidate_);
      progress_.watch.lap(progress_.summary.seconds_linearize);
      if (cost < progress_.summary.cost) {
        region_.accept((progress_.summary.cost - cost) / step.predicted, step.length);
        std::swap(best_, candidate_);
        progress_.summary.cost = cost;
        return true;
      }
      const double rounding = std::max(kRounding, 1e-2 * progress_.cost_tolerance()) * progress_.summary.cost;
      if (step.is_full && step.predicted <= rounding) {
        if (cost <= (1 + kRounding) * progress_.summary.cost) {  // costs no longer differ, and the model still knows where the minimum is
          std::swap(best_, candidate_);
          return true;
        }
        progress_.end(Termination::converged, "the model predicts no decrease beyond cost_tolerance");
        return false;
      }
      region_.reject(step.length);
      if (shrinks < kMostShrinks && !progress_.go_on(gradient_norm)) return false;
    }
    progress_.end(Termination::converged, "no step, however short, lowers the cost");
    return false;
  }

  const Graph& graph_;
  QuadraticModel& system_;
  Values& best_;
  Values candidate_;
  Progress& progress_;
  Dogleg dogleg_;
  TrustRegion region_;
  std::vector<double> step_;
};

}  // namespace

void descend_by_dogleg(const Graph& graph, QuadraticModel& system, Values& values, Progress& progress) {
  Descent(graph, system, values, progress).run();
}

}  // namespace holdfast::detail
