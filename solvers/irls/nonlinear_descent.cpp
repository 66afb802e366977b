#include <algorithm>
#include <cmath>
#include <holdfast/graph/starts/chordal.hpp>
#include <holdfast/solvers/irls/internal/nonlinear_descent.hpp>

namespace holdfast::detail {
namespace {

constexpr double kRounding = 1e-14;  // of the cost: a predicted decrease below this cannot be measured
constexpr int kMostShrinks = 50;
constexpr double kStrangeGain = 0.5;  // off by so much, the quadratic model says little: a poor start, or the way to a poor minimum
constexpr double kLinearGain = 0.1;   // actual over predicted decrease this near to 1: the residuals are straight enough as they are

}  // namespace

struct NonlinearDescent::Run {
  const Graph& graph;
  NewtonSystem& system;
  Values& best;
  const Rules& rules;
  Progress& progress;
  Summary& summary = progress.summary;
};

NonlinearDescent::NonlinearDescent(const Graph& graph, const Values& values, const NewtonSystem& system)
    : dogleg_(system), geodesic_(graph, system), candidate_(values), step_(system.size()), tangent_(system.size()) {}

void NonlinearDescent::minimize(const Graph& graph, NewtonSystem& system, Values& values, const Rules& rules, Progress& progress) {
  Run run{graph, system, values, rules, progress};
  candidate_.assign(values);
  may_restart_ = rules.may_restart;
  other_start_.reset();
  const double first = linearize(run);
  if (!progress.begin(first, graph, system.resolved(), values)) return;
  descend(run);
  if (other_start_ && progress.summary.termination == Termination::converged) descend_from_other_start(run);
}

double NonlinearDescent::linearize(Run& run) {
  const double cost = run.system.linearize(run.graph, run.best, run.rules.curvature);
  run.progress.watch.lap(run.summary.seconds_linearize);
  return cost;
}

// From `best`, where the problem has been linearised.
void NonlinearDescent::descend(Run& run) {
  region_ = TrustRegion();
  bends_ = false;
  double gradient_norm = max_norm(run.system.gradient());
  while (!run.progress.gradient_is_flat(gradient_norm) && run.progress.go_on(gradient_norm)) {
    ++run.summary.iterations;
    const double before = run.summary.cost;
    const Outcome outcome = step(run, gradient_norm);
    if (outcome == Outcome::over) break;
    linearize(run);
    gradient_norm = max_norm(run.system.gradient());
    if (outcome == Outcome::full_step && run.progress.decrease_is_small(before, run.summary.cost)) break;
  }
  run.summary.gradient_norm = gradient_norm;
}

// Steps of one factorisation, shorter and shorter, until one lowers the cost.
NonlinearDescent::Outcome NonlinearDescent::step(Run& run, double gradient_norm) {
  if (!dogleg_.begin(run.system)) {
    run.progress.end(Termination::failed, "the normal equations are not positive definite under any damping");
    return Outcome::over;
  }
  for (int shrinks = 0; shrinks <= kMostShrinks; ++shrinks) {
    Dogleg::Step step{};
    switch (try_step(run, step)) {
      case Try::lower:
      case Try::level:
        return step.is_full ? Outcome::full_step : Outcome::short_step;
      case Try::no_decrease_left:
        run.progress.end(Termination::converged, "the model predicts no decrease beyond cost_tolerance");
        return Outcome::over;
      case Try::higher:
        if (restart(run)) return Outcome::restarted;
        bends_ = true;
        region_.reject(step.length);
    }
    if (shrinks < kMostShrinks && !run.progress.go_on(gradient_norm)) return Outcome::over;
  }
  run.progress.end(Termination::converged, "no step, however short, lowers the cost");
  return Outcome::over;
}

NonlinearDescent::Try NonlinearDescent::try_step(Run& run, Dogleg::Step& step) {
  const Resolved& resolved = run.system.resolved();
  Summary& summary = run.summary;
  step = dogleg_.take(run.system, region_.radius(), step_);
  run.progress.watch.lap(summary.seconds_solve);
  run.system.to_tangent(step_, tangent_);
  if (bends_) geodesic_.bend(run.graph, run.system, run.best, step_, tangent_, candidate_);
  resolved.retract(run.best, tangent_.data(), candidate_);
  const double cost = resolved.cost(run.graph, candidate_, &run.system.pool());
  run.progress.watch.lap(summary.seconds_linearize);
  if (cost < summary.cost) {
    const double gain = (summary.cost - cost) / step.predicted;
    region_.accept(gain, step.length);
    bends_ = std::abs(gain - 1) > kLinearGain;
    std::swap(run.best, candidate_);
    summary.cost = cost;
    if (std::abs(gain - 1) > kStrangeGain) restart(run);
    return Try::lower;
  }
  if (!step.is_full || step.predicted > std::max(kRounding, 1e-2 * run.rules.cost_tolerance) * summary.cost) return Try::higher;
  if (!(cost <= (1 + kRounding) * summary.cost)) return Try::no_decrease_left;
  std::swap(run.best, candidate_);  // costs no longer differ, and the model still knows where the minimum is
  return Try::level;
}

// After the first step that failed or was far from its model. True where the chordal start is the better place, and the descent goes on
// from there.
bool NonlinearDescent::restart(Run& run) {
  if (!std::exchange(may_restart_, false)) return false;
  candidate_.assign(run.best);
  if (!chordal_start(run.graph, candidate_)) return false;
  ++run.summary.restarts;
  const double cost = run.system.resolved().cost(run.graph, candidate_, &run.system.pool());
  run.progress.watch.lap(run.summary.seconds_setup);
  if (std::isfinite(cost) && cost >= run.summary.cost) other_start_ = std::make_unique<Values>(candidate_);
  if (!(cost < run.summary.cost)) return false;
  std::swap(run.best, candidate_);
  run.summary.cost = cost;
  region_ = TrustRegion();
  return true;
}

void NonlinearDescent::descend_from_other_start(Run& run) {
  Summary& summary = run.summary;
  const Values end = run.best;
  const double cost = summary.cost, gradient_norm = summary.gradient_norm;
  const char* const rule = summary.rule;
  run.best.assign(*other_start_);
  run.progress.best_elsewhere = cost;
  summary.cost = linearize(run);
  descend(run);
  if (summary.cost < cost) return;
  run.best.assign(end);
  summary.cost = cost;
  summary.gradient_norm = gradient_norm;
  run.progress.end(Termination::converged, rule);
}

}  // namespace holdfast::detail
