#include <cmath>
#include <holdfast/graph/gradient.hpp>
#include <holdfast/solvers/distributed/internal/distributed_solve.hpp>
#include <holdfast/solvers/distributed/nesterov_mpi.hpp>
#include <holdfast/solvers/nesterov/internal/chain_preconditioner.hpp>
#include <numeric>

namespace holdfast {
namespace {

constexpr int kMaxIterations = 10000;
constexpr double kSteep = 8;   // an L above this says that P misses curvature
constexpr int kPatience = 50;  // iterations over which a slow decrease is measured
constexpr double kRounding = 1e-14, kMostLipschitz = 1e30;

/// Nesterov's sequences, each process its part; every decision is made of sums that all have.
class Run {
 public:
  Run(detail::DistributedProblem& problem, int threads)
      : problem_(problem),
        all_(problem.communicator()),
        graph_(problem.graph()),
        resolved_(problem.resolved()),
        evaluate_(graph_),
        preconditioner_(graph_, resolved_),
        pool_(threads),
        x_(problem.values()),
        y_(x_),
        next_(x_),
        step_(resolved_.tangent_dim()) {}

  const Values& x() const { return x_; }
  bool plain() const { return plain_; }
  double norm2() const { return norm2_; }
  double cost() { return problem_.cost(x_, &pool_); }

  void measure() { preconditioner_.update(graph_, resolved_, x_, &pool_); }

  /// The gradient at y, its direction in the metric, the cost there; the largest component of the gradient of all.
  double look() {
    evaluate_(graph_, resolved_, y_, gradient_, &pool_);
    double sums[2] = {problem_.own_cost(y_, &pool_), preconditioner_.apply(resolved_, gradient_, direction_)};
    all_.sum(sums, 2);
    cost_y_ = sums[0];
    norm2_ = sums[1];
    return all_.max(max_norm(gradient_));
  }

  /// next = y ⊕ −(1/L) direction, L raised until f(next) ≤ f(y) − norm2 / 2L; f(next), NaN where no L does.
  double backtrack() {
    if (!std::isfinite(cost_y_) || !std::isfinite(norm2_)) return NAN;
    for (; L_ < kMostLipschitz; L_ *= 2) {
      for (std::size_t i = 0; i < step_.size(); ++i) step_[i] = -direction_[i] / L_;
      resolved_.retract(y_, step_.data(), next_);
      problem_.update(next_);
      const double cost = problem_.cost(next_, &pool_);
      if (cost <= cost_y_ - norm2_ / (2 * L_) + kRounding * std::abs(cost_y_)) return cost;
    }
    return NAN;
  }

  /// x = next, and y ahead of it; no momentum where it points uphill.
  void accept() {
    const double t_next = (1 + std::sqrt(1 + 4 * t_ * t_)) / 2, beta = (t_ - 1) / t_next;
    resolved_.local(x_, next_, step_.data());
    const bool uphill = all_.sum(std::inner_product(step_.begin(), step_.end(), gradient_.begin(), 0.0)) > 0;
    std::swap(x_, next_);
    plain_ = t_ == 1 || uphill;
    t_ = uphill ? 1 : t_next;
    if (uphill) {
      y_.assign(x_);
    } else {
      for (double& s : step_) s *= beta;
      resolved_.retract(x_, step_.data(), y_);
      problem_.update(y_);
    }
    if (L_ > kSteep && round_off()) restart();
    L_ *= 0.98;
  }

  /// Momentum went too far: once more from x, in a metric of the losses' weights there.
  void begin_again() {
    measure();
    if (L_ > kSteep) round_off();
    restart();
  }

  double gradient_norm_at_x() {
    evaluate_(graph_, resolved_, x_, gradient_, &pool_);
    return all_.max(max_norm(gradient_));
  }

 private:
  bool round_off() { return all_.any(preconditioner_.round_off()); }
  void restart() {
    y_.assign(x_);
    t_ = L_ = 1;
    plain_ = true;
  }

  detail::DistributedProblem& problem_;
  const Communicator& all_;
  const Graph& graph_;
  const Resolved& resolved_;
  GradientEvaluator evaluate_;
  ChainPreconditioner preconditioner_;
  ThreadPool pool_;
  Values x_, y_, next_;
  std::vector<double> gradient_, direction_, step_;
  double t_ = 1, L_ = 1, cost_y_ = 0, norm2_ = 0;
  bool plain_ = true;
};

}  // namespace

Summary NesterovMpi::solve(DistributedGraph& graph) {
  return detail::solve_together(graph, options, true, [this](detail::DistributedProblem& problem) { return descend(problem); });
}

Summary NesterovMpi::minimize(const Graph& graph, Values& values) {
  detail::DistributedProblem problem(graph, values);
  return descend(problem);
}

Summary NesterovMpi::descend(detail::DistributedProblem& problem) {
  Progress progress(options, kMaxIterations);
  Summary& summary = progress.summary;
  detail::watch_together(problem, options, progress);
  Run run(problem, options.threads);
  if (!progress.begin(run.cost())) {
    summary.culprit = problem.first_non_finite(problem.values());
    return std::move(summary);
  }
  run.measure();
  progress.watch.lap(summary.seconds_setup);

  double gradient_norm = run.gradient_norm_at_x(), patience_cost = summary.cost;
  while (progress.go_on(gradient_norm)) {
    gradient_norm = run.look();
    if (run.plain() && progress.gradient_is_flat(gradient_norm)) break;
    ++summary.iterations;
    const double cost = run.backtrack();
    if (!(cost < summary.cost)) {
      if (run.plain()) {
        progress.end(Termination::converged, "no step, however short, lowers the cost");
        break;
      }
      run.begin_again();
      continue;
    }
    run.accept();
    summary.cost = cost;
    if (summary.iterations % kPatience == 0) {
      if (run.norm2() / 2 <= options.cost_tolerance * summary.cost && progress.decrease_is_small(patience_cost, summary.cost)) break;
      patience_cost = summary.cost;
    }
  }
  problem.values().assign(run.x());
  summary.gradient_norm = run.gradient_norm_at_x();
  return std::move(summary);
}

}  // namespace holdfast
