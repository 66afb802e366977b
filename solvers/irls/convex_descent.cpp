#include <algorithm>
#include <cmath>
#include <holdfast/solvers/irls/internal/convex_descent.hpp>

namespace holdfast::detail {
namespace {

constexpr double kFirstLambda = 1, kGrow = 3, kFall = 0.1, kLeastLambda = 1e-12, kMostLambda = 1e9;
constexpr double kArmijo = 1e-4;
constexpr int kMostCuts = 40;
constexpr double kRounding = 1e-14;  // of the cost: a decrease below this cannot be measured

}  // namespace

bool ConvexDescent::serves(const Graph& graph) {
  return is_convex_problem(graph) &&
         std::any_of(graph.batches().begin(), graph.batches().end(), [](const auto& batch) { return batch->has_hessian(); });
}

void ConvexDescent::minimize(const Graph& graph, NewtonSystem& system, Values& values, Progress& progress) {
  Summary& summary = progress.summary;
  for (std::vector<double>* v : {&step_, &tangent_, &scaled_}) v->resize(system.size());
  scales_.assign(system.size(), 0);
  candidate_.assign(values);
  const double first = system.linearize(graph, values, Curvature::exact);
  progress.watch.lap(summary.seconds_linearize);
  if (!progress.begin(first, graph, system.resolved(), values)) return;
  lambda_ = kFirstLambda;
  double gradient_norm = max_norm(system.gradient());
  while (!progress.gradient_is_flat(gradient_norm) && progress.go_on(gradient_norm)) {
    ++summary.iterations;
    const bool goes_on = step(graph, system, values, progress);
    system.linearize(graph, values, Curvature::exact);
    progress.watch.lap(summary.seconds_linearize);
    gradient_norm = max_norm(system.gradient());
    if (!goes_on) break;
  }
  summary.gradient_norm = gradient_norm;
  if (summary.termination == Termination::failed) return;
  update_scales(system);
  summary.decrement = system.solve_damped(lambda_, scales_, step_);
  progress.watch.lap(summary.seconds_solve);
}

void ConvexDescent::update_scales(const NewtonSystem& system) {
  for (std::size_t i = 0; i < scales_.size(); ++i) scales_[i] = std::max(scales_[i], system.diagonal()[i]);
}

// False where it was the last one.
bool ConvexDescent::step(const Graph& graph, NewtonSystem& system, Values& values, Progress& progress) {
  Summary& summary = progress.summary;
  update_scales(system);
  double predicted = system.solve_damped(lambda_, scales_, step_);
  while (!std::isfinite(predicted) && lambda_ < kMostLambda)
    predicted = system.solve_damped(lambda_ = std::max(kLeastLambda, 10 * lambda_), scales_, step_);
  progress.watch.lap(summary.seconds_solve);
  if (!std::isfinite(predicted)) {
    progress.end(Termination::failed, "the normal equations are not positive definite under any damping");
    return false;
  }
  const double before = summary.cost;
  if (predicted <= kRounding * before) {
    progress.end(Termination::converged, "the model predicts no decrease beyond rounding");
    return false;
  }
  system.to_tangent(step_, tangent_);
  double cost = before;
  const double t = search(graph, system, values, before, dot(system.gradient(), step_), cost);
  progress.watch.lap(summary.seconds_linearize);
  if (t == 0) {
    progress.end(Termination::converged, "no step, however short, lowers the cost");
    return false;
  }
  std::swap(values, candidate_);
  summary.cost = cost;
  if (t < 1)
    lambda_ = std::max(kGrow * lambda_, kLeastLambda);
  else
    lambda_ = lambda_ <= kLeastLambda ? 0 : kFall * lambda_;
  return !(t == 1 && predicted <= progress.cost_tolerance() * before && progress.decrease_is_small(before, cost));
}

double ConvexDescent::search(const Graph& graph, NewtonSystem& system, const Values& values, double before, double slope, double& cost) {
  double t = 1;
  for (int cuts = 0; cuts <= kMostCuts; ++cuts) {
    for (std::size_t i = 0; i < tangent_.size(); ++i) scaled_[i] = t * tangent_[i];
    system.resolved().retract(values, scaled_.data(), candidate_);
    cost = system.resolved().cost(graph, candidate_, &system.pool());
    if (cost <= before + kArmijo * t * slope) return t;
    t *= 0.5;  // interpolation asks for shorter steps, and for twice as many of them: the cost is smooth only piece by piece
  }
  return 0;
}

}  // namespace holdfast::detail
