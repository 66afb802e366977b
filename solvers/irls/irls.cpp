#include <algorithm>
#include <cmath>
#include <holdfast/graph/starts/chordal.hpp>
#include <holdfast/solvers/irls/internal/workspace.hpp>
#include <holdfast/solvers/irls/irls.hpp>
#include <holdfast/solvers/linear/internal/linear_rows.hpp>

namespace holdfast {
namespace {

constexpr int kMaxIterations = 1000;
constexpr double kRounding = 1e-14;  // of the cost: a predicted decrease below this cannot be measured
constexpr double kFull = 0.1;  // a step shorter than this part of Newton's is short because of the radius, not because the minimum is near
constexpr int kMostShrinks = 50;
constexpr double kStrangeGain = 0.5;  // off by so much, the quadratic model says little: a poor start, or the way to a poor minimum
constexpr double kLinearGain = 0.1;   // actual over predicted decrease this near to 1: the residuals are straight enough as they are

void require_unknowns(const Resolved& resolved) {
  if (resolved.tangent_dim() == 0) fail<BadProblem>("every variable that a factor touches is fixed; there is nothing to solve for");
}

}  // namespace

Irls::Irls(Options chosen, IrlsOptions of_irls)
    : Backend(std::move(chosen)), irls_options(of_irls), rows_(std::make_unique<LinearRows>()) {}
Irls::~Irls() = default;

Curvature Irls::curvature(const Graph& graph, bool linear) const {
  if (irls_options.reweighting == Reweighting::irls) return Curvature::irls;
  if (irls_options.reweighting == Reweighting::newton) return Curvature::newton;
  const bool convex =
      std::all_of(graph.batches().begin(), graph.batches().end(), [](const auto& batch) { return batch->family().is_convex(); });
  return linear && convex ? Curvature::newton : Curvature::irls;
}

Summary Irls::minimize(const Graph& graph, Values& values) {
  Progress progress(options, kMaxIterations);
  const bool linear = std::all_of(graph.batches().begin(), graph.batches().end(), [](const auto& batch) { return batch->is_linear(); });
  if (linear && rows_->load(graph, values)) {
    require_unknowns(rows_->resolved());
    progress.watch.lap(progress.summary.seconds_setup);
    minimize_rows(graph, values, progress);
    return std::move(progress.summary);
  }
  if (!workspace_ || !workspace_->resolved.matches(graph, values) || workspace_->pool.threads() != options.threads)
    workspace_ = std::make_unique<Workspace>(graph, values, options.threads);
  Workspace& w = *workspace_;
  require_unknowns(w.resolved);
  w.best.assign(values);
  w.candidate.assign(values);
  progress.watch.lap(progress.summary.seconds_setup);
  if (linear)
    minimize_linear(graph, progress);
  else
    minimize_nonlinear(graph, progress);
  if (progress.summary.usable()) values.assign(w.best);
  return std::move(progress.summary);
}

void Irls::minimize_nonlinear(const Graph& graph, Progress& progress) {
  Workspace& w = *workspace_;
  w.may_restart = irls_options.restart;
  w.other_start.reset();
  const double first = linearize(graph, progress);
  if (!progress.begin(first, graph, w.resolved, w.best)) return;
  descend_nonlinear(graph, progress);
  if (w.other_start && progress.summary.termination == Termination::converged) descend_from_other_start(graph, progress);
}

double Irls::linearize(const Graph& graph, Progress& progress) {
  Workspace& w = *workspace_;
  const double cost = w.normal.linearize(graph, w.resolved, w.best, curvature(graph, false), &w.pool);
  progress.watch.lap(progress.summary.seconds_linearize);
  return cost;
}

// From `best`, where the problem has been linearised.
void Irls::descend_nonlinear(const Graph& graph, Progress& progress) {
  Workspace& w = *workspace_;
  Summary& summary = progress.summary;
  w.region = TrustRegion();
  w.bends = false;
  double gradient_norm = max_norm(w.normal.gradient());
  while (!progress.gradient_is_flat(gradient_norm) && progress.go_on(gradient_norm)) {
    const double before = summary.cost;
    bool full = true;
    if (!step_nonlinear(graph, progress, gradient_norm, full)) break;
    linearize(graph, progress);
    gradient_norm = max_norm(w.normal.gradient());
    if (full && progress.decrease_is_small(before, summary.cost)) break;
  }
  summary.gradient_norm = gradient_norm;
}

// After the first step that failed or was far from its model. True where the chordal start is the better place, and the descent goes on
// from there.
bool Irls::restart(const Graph& graph, Progress& progress) {
  Workspace& w = *workspace_;
  if (!std::exchange(w.may_restart, false)) return false;
  w.candidate.assign(w.best);
  if (!chordal_start(graph, w.candidate)) return false;
  ++progress.summary.restarts;
  const double cost = w.resolved.cost(graph, w.candidate, &w.pool);
  progress.watch.lap(progress.summary.seconds_setup);
  if (std::isfinite(cost) && cost >= progress.summary.cost) w.other_start = std::make_unique<Values>(w.candidate);
  if (!(cost < progress.summary.cost)) return false;
  std::swap(w.best, w.candidate);
  progress.summary.cost = cost;
  w.region = TrustRegion();
  return true;
}

void Irls::descend_from_other_start(const Graph& graph, Progress& progress) {
  Workspace& w = *workspace_;
  Summary& summary = progress.summary;
  const Values end = w.best;
  const double cost = summary.cost, gradient_norm = summary.gradient_norm;
  const char* const rule = summary.rule;
  w.best.assign(*w.other_start);
  progress.best_elsewhere = cost;
  summary.cost = linearize(graph, progress);
  descend_nonlinear(graph, progress);
  if (summary.cost < cost) return;
  w.best.assign(end);
  summary.cost = cost;
  summary.gradient_norm = gradient_norm;
  progress.end(Termination::converged, rule);
}

// One factorisation, and steps of it, shorter and shorter, until one lowers the cost; false when the solve is over.
bool Irls::step_nonlinear(const Graph& graph, Progress& progress, double gradient_norm, bool& full) {
  Workspace& w = *workspace_;
  Summary& summary = progress.summary;
  for (int shrinks = 0;; ++shrinks) {
    if (shrinks == 0) {
      ++summary.iterations;
      if (!w.find_newton_step()) {
        progress.end(Termination::failed, "the normal equations are not positive definite under any damping");
        return false;
      }
    }
    const Workspace::Step step = w.take_dogleg_step(w.region.radius());
    progress.watch.lap(summary.seconds_solve);
    w.normal.to_tangent(w.resolved, w.step.data(), w.tangent.data());
    if (w.bends) w.accelerate(graph);
    w.resolved.retract(w.best, w.tangent.data(), w.candidate);
    const double cost = w.resolved.cost(graph, w.candidate, &w.pool);
    progress.watch.lap(summary.seconds_linearize);
    full = step.length >= kFull * w.newton_length;
    if (cost < summary.cost) {
      const double gain = (summary.cost - cost) / step.predicted;
      w.region.accept(gain, step.length);
      w.bends = std::abs(gain - 1) > kLinearGain;
      std::swap(w.best, w.candidate);
      summary.cost = cost;
      if (std::abs(gain - 1) > kStrangeGain) restart(graph, progress);
      return true;
    }
    if (full && step.predicted <= std::max(kRounding, 1e-2 * options.cost_tolerance) * summary.cost) {
      if (cost <= (1 + kRounding) * summary.cost) {  // costs no longer differ, and the model still knows where the minimum is
        std::swap(w.best, w.candidate);
        return true;
      }
      progress.end(Termination::converged, "the model predicts no decrease beyond cost_tolerance");
      return false;
    }
    if (restart(graph, progress)) {
      linearize(graph, progress);
      shrinks = -1;
      continue;
    }
    w.bends = true;
    w.region.reject(step.length);
    if (shrinks == kMostShrinks) {
      progress.end(Termination::converged, "no step, however short, lowers the cost");
      return false;
    }
    if (!progress.go_on(gradient_norm)) return false;
  }
}

}  // namespace holdfast
