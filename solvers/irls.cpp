#include <algorithm>
#include <cmath>
#include <holdfast/solvers/block_cholesky.hpp>
#include <holdfast/solvers/irls.hpp>
#include <holdfast/solvers/minimizer.hpp>

namespace holdfast {
namespace {

constexpr int kMaxIterations = 100;
constexpr double kFirstDamping = 1e-5;   // where Gauss–Newton fails
constexpr double kLeastDamping = 1e-9;   // below this: Gauss–Newton again
constexpr double kMostDamping = 1e20;
constexpr double kRounding = 1e-14;      // of the cost: a predicted decrease below this cannot be measured

}  // namespace

// Everything that depends on the structure only, and the memory of one iteration.
struct Irls::Workspace {
  Resolved resolved;
  std::vector<int> variable;  // of each node of the block graph
  Symbolic symbolic;
  NormalEquations normal;
  BlockCholesky cholesky;
  ThreadPool pool;
  Values candidate;
  std::vector<double> damping, diagonal, rhs, step, tangent;

  Workspace(const Graph& graph, const Values& values, int threads)
      : resolved(graph, values),
        symbolic(analyze(block_graph(graph, resolved, variable))),
        normal(graph, resolved, variables_in_order()),
        cholesky(std::move(symbolic), normal.pattern()),
        pool(threads),
        candidate(values) {
    const std::size_t n = resolved.tangent_dim();
    for (std::vector<double>* v : {&damping, &diagonal, &rhs, &step, &tangent}) v->resize(n);
  }

  std::vector<int> variables_in_order() const {
    std::vector<int> order;
    for (int node : symbolic.order) order.push_back(variable[node]);
    return order;
  }

  void read_diagonal() {
    const BlockPattern& pattern = normal.pattern();
    for (int i = 0; i < pattern.size(); ++i) {
      const double* block = &normal.H()[pattern.block_begin[pattern.column_begin[i]]];
      for (int c = 0; c < pattern.dims[i]; ++c) diagonal[pattern.offsets[i] + c] = block[c * (pattern.dims[i] + 1)];
    }
  }

  /// (H + λ D) δ = −g; returns the decrease of the cost that the quadratic model predicts, or NaN where H + λ D is not positive definite.
  double solve_damped(double lambda) {
    constexpr double kLeastDiagonal = 1e-12;  // an unconstrained direction must feel the damping, too
    for (std::size_t i = 0; i < damping.size(); ++i) damping[i] = lambda * std::max(diagonal[i], kLeastDiagonal);
    if (!cholesky.factor(normal.H(), damping, &pool)) return NAN;
    const std::vector<double>& g = normal.gradient();
    for (std::size_t i = 0; i < rhs.size(); ++i) rhs[i] = -g[i];
    cholesky.solve(rhs, step);
    double predicted = 0;
    for (std::size_t i = 0; i < step.size(); ++i) predicted += 0.5 * step[i] * (damping[i] * step[i] - g[i]);
    return predicted;
  }
};

Irls::Irls(Options chosen) : Backend(std::move(chosen)) {}
Irls::~Irls() = default;

namespace {

// λ, as Nielsen moves it: down by how well the model predicted, up faster with every failure in a row.
class Damping {
 public:
  double lambda() const { return lambda_; }
  void accept(double gain_ratio) {
    const double u = 2 * gain_ratio - 1;
    lambda_ *= std::max(1.0 / 3, 1 - u * u * u);
    if (lambda_ < kLeastDamping) lambda_ = 0;
    growth_ = 4;
  }
  /// False when there is nothing left to try.
  bool reject() {
    lambda_ = lambda_ == 0 ? kFirstDamping : lambda_ * growth_;
    growth_ *= 2;
    return lambda_ < kMostDamping;
  }

 private:
  double lambda_ = 0;
  double growth_ = 4;
};

}  // namespace

Summary Irls::minimize(const Graph& graph, Values& values) {
  Progress progress(options, kMaxIterations);
  Summary& summary = progress.summary;
  if (!workspace_ || !workspace_->resolved.matches(graph, values) || workspace_->pool.threads() != options.threads)
    workspace_ = std::make_unique<Workspace>(graph, values, options.threads);
  Workspace& w = *workspace_;
  if (w.resolved.tangent_dim() == 0) fail<BadProblem>("every variable that a factor touches is fixed; there is nothing to solve for");
  Values best = values;
  progress.watch.lap(summary.seconds_setup);

  Damping damping;
  if (!progress.begin(w.normal.linearize(graph, w.resolved, best, Curvature::irls, &w.pool), graph, w.resolved, best)) return summary;
  progress.watch.lap(summary.seconds_linearize);
  for (;;) {
    const double gradient_norm = max_norm(w.normal.gradient());
    if (progress.gradient_is_flat(gradient_norm)) summary.gradient_norm = gradient_norm;
    if (summary.termination == Termination::converged || !progress.go_on(gradient_norm)) break;
    w.read_diagonal();
    double cost = summary.cost, predicted = 0;
    bool accepted = false;
    while (!accepted) {
      ++summary.iterations;
      predicted = w.solve_damped(damping.lambda());
      progress.watch.lap(summary.seconds_solve);
      if (std::isfinite(predicted)) {
        w.normal.to_tangent(w.resolved, w.step.data(), w.tangent.data());
        w.candidate.assign(best);
        w.resolved.retract(best, w.tangent.data(), w.candidate);
        cost = w.resolved.cost(graph, w.candidate, &w.pool);
        progress.watch.lap(summary.seconds_linearize);
        accepted = cost < summary.cost;
      }
      if (accepted) break;
      if (predicted <= std::max(kRounding, 1e-2 * options.cost_tolerance) * summary.cost && damping.lambda() <= 1) {
        progress.end(Termination::converged, "the model predicts no decrease beyond rounding");
        break;
      }
      if (!damping.reject()) {
        progress.end(Termination::converged, "no step, however short, lowers the cost");
        break;
      }
      if (!progress.go_on(gradient_norm)) break;
    }
    if (!accepted) break;
    const double before = summary.cost;
    std::swap(best, w.candidate);
    summary.cost = cost;
    damping.accept((before - cost) / predicted);
    w.normal.linearize(graph, w.resolved, best, Curvature::irls, &w.pool);
    progress.watch.lap(summary.seconds_linearize);
    if (progress.decrease_is_small(before, cost)) {
      summary.gradient_norm = max_norm(w.normal.gradient());
      break;
    }
  }
  values.assign(best);
  return summary;
}

}  // namespace holdfast
