#include <algorithm>
#include <cmath>
#include <holdfast/solvers/irls/internal/convex_descent.hpp>

namespace holdfast::detail {
namespace {

constexpr double kFirstLambda = 1, kGrow = 3, kFall = 0.1, kLeastLambda = 1e-12, kMostLambda = 1e9;
constexpr double kWeakLambda = 1e-6;  // a model damped by more may predict little far from the minimum
constexpr double kArmijo = 1e-4;
constexpr int kMostCuts = 40;
constexpr double kRounding = 1e-14;  // of the cost: a decrease below this cannot be measured

}  // namespace

bool ConvexDescent::serves(const Graph& graph) {
  return is_convex_problem(graph) &&
         std::any_of(graph.batches().begin(), graph.batches().end(), [](const auto& batch) { return batch->has_hessian(); });
}

void ConvexDescent::minimize(const Graph& graph, QuadraticModel& system, Values& values, Progress& progress) {
  Summary& summary = progress.summary;
  step_.resize(system.size());
  scales_.assign(system.size(), 0);
  candidate_.assign(values);
  const double first = system.linearize(graph, values, Curvature::exact);
  progress.watch.lap(summary.seconds_linearize);
  if (!progress.begin(first)) {
    summary.culprit = system.first_non_finite(graph, values);
    return;
  }
  lambda_ = kFirstLambda;
  bool is_at_end = false;
  double gradient_norm = system.gradient_norm();
  while (!progress.gradient_is_flat(gradient_norm) && progress.go_on(gradient_norm)) {
    ++summary.iterations;
    const double before = summary.cost;
    const Step taken = step(graph, system, values, progress);
    system.linearize(graph, values, Curvature::exact);
    progress.watch.lap(summary.seconds_linearize);
    gradient_norm = system.gradient_norm();
    is_at_end = taken != Step::goes_on && is_at_minimum(system, taken, before, progress);
    if (is_at_end || taken == Step::failed) break;
  }
  summary.gradient_norm = gradient_norm;
  if (summary.termination != Termination::failed && !is_at_end) predict_undamped(system, progress);
}

// The decrease that the model predicts with next to no damping: the Summary's decrement.
double ConvexDescent::predict_undamped(QuadraticModel& system, Progress& progress) {
  update_scales(system);
  progress.summary.decrement = system.solve_damped(std::min(lambda_, kWeakLambda), scales_, step_);
  progress.watch.lap(progress.summary.seconds_solve);
  return progress.summary.decrement;
}

// A step may be short for its damping alone.
bool ConvexDescent::is_at_minimum(QuadraticModel& system, Step taken, double before, Progress& progress) {
  const double cost = progress.summary.cost;
  if (predict_undamped(system, progress) > std::max(progress.cost_tolerance(), kRounding) * cost) {
    if (taken == Step::short_of_decrease) return false;
    if (lambda_ > kWeakLambda) {  // the same damping again would find the same
      lambda_ = kWeakLambda;
      return false;
    }
  }
  if (taken == Step::short_of_decrease) return progress.decrease_is_small(before, cost);
  progress.end(Termination::converged, taken == Step::nothing_predicted ? "the model predicts no decrease beyond rounding"
                                                                        : "no step, however short, lowers the cost");
  return true;
}

void ConvexDescent::update_scales(const QuadraticModel& system) {
  for (std::size_t i = 0; i < scales_.size(); ++i) scales_[i] = std::max(scales_[i], system.diagonal()[i]);
}

ConvexDescent::Step ConvexDescent::step(const Graph& graph, QuadraticModel& system, Values& values, Progress& progress) {
  Summary& summary = progress.summary;
  update_scales(system);
  double predicted = system.solve_damped(lambda_, scales_, step_);
  while (!std::isfinite(predicted) && lambda_ < kMostLambda)
    predicted = system.solve_damped(lambda_ = std::max(kLeastLambda, 10 * lambda_), scales_, step_);
  progress.watch.lap(summary.seconds_solve);
  if (!std::isfinite(predicted)) {
    progress.end(Termination::failed, "the normal equations are not positive definite under any damping");
    return Step::failed;
  }
  const double before = summary.cost;
  if (predicted <= kRounding * before) return Step::nothing_predicted;
  double cost = before;
  const double t = search(graph, system, values, before, system.dot(system.gradient(), step_), cost);
  progress.watch.lap(summary.seconds_linearize);
  if (t == 0) return Step::nothing_lower;
  std::swap(values, candidate_);
  summary.cost = cost;
  if (t < 1)
    lambda_ = std::max(kGrow * lambda_, kLeastLambda);
  else
    lambda_ = lambda_ <= kLeastLambda ? 0 : kFall * lambda_;
  const double small = progress.cost_tolerance() * before;
  return t == 1 && predicted <= small && before - cost <= small ? Step::short_of_decrease : Step::goes_on;
}

double ConvexDescent::search(const Graph& graph, QuadraticModel& system, const Values& values, double before, double slope, double& cost) {
  double t = 1;
  for (int cuts = 0; cuts <= kMostCuts; ++cuts) {
    system.retract(values, t, step_, candidate_);
    cost = system.cost(graph, candidate_);
    if (cost <= before + kArmijo * t * slope) return t;
    t *= 0.5;  // interpolation asks for shorter steps, and for twice as many of them: the cost is smooth only piece by piece
  }
  return 0;
}

}  // namespace holdfast::detail
