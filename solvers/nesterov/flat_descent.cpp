#include <cmath>
#include <holdfast/solvers/nesterov/internal/flat_descent.hpp>

namespace holdfast::detail {
namespace {

constexpr double kForget = 0.9;  // of L, an iteration: how fast it falls to what the last steps showed
constexpr double kLeastL = 0.5;
constexpr int kLook = 10;      // iterations between two looks at the cost
constexpr int kPatience = 50;  // iterations over which a slow decrease is measured
constexpr double kApart = 1e6;
constexpr double kMostL = 1e30;

/// Every variable far from every other.
std::vector<double> apart(std::size_t n) {
  std::vector<double> u(n);
  for (std::size_t i = 0; i < n; ++i) u[i] = kApart * std::sin(1.0 + static_cast<double>(i));
  return u;
}

}  // namespace

bool FlatDescent::serves(const Graph& graph, const Values& values) { return is_convex_problem(graph) && FlatValues::serves(graph, values); }

FlatDescent::FlatDescent(const Graph& graph, const Values& start, ChainPreconditioner::Kept kept, int threads)
    : graph_(graph),
      resolved_(graph, start),
      evaluate_(graph),
      preconditioner_(graph, resolved_, kept),
      pool_(threads),
      flat_(resolved_, start),
      at_(start) {
  if (resolved_.tangent_dim() == 0) fail<BadProblem>("every variable that a factor touches is fixed; there is nothing to solve for");
  for (std::vector<double>* v : {&x_, &y_, &best_, &g_, &d_, &last_y_, &last_g_, &last_d_}) v->assign(resolved_.tangent_dim(), 0.0);
}

void FlatDescent::minimize(Values& values, Progress& progress) {
  Summary& summary = progress.summary;
  if (!progress.begin(resolved_.cost(graph_, values, &pool_), graph_, resolved_, values)) return;
  flat_.write(apart(x_.size()), at_);
  preconditioner_.update(graph_, resolved_, at_, &pool_);
  progress.watch.lap(summary.seconds_setup);
  evaluate_(graph_, resolved_, values, g_, &pool_);
  double gradient_norm = max_norm(g_), patience_cost = summary.cost;
  while (progress.go_on(gradient_norm)) {
    flat_.write(y_, at_);
    evaluate_(graph_, resolved_, at_, g_, &pool_);
    gradient_norm = max_norm(g_);
    if (t_ == 1 && progress.gradient_is_flat(gradient_norm)) break;
    const double norm2 = preconditioner_.apply(resolved_, g_, d_);
    ++summary.iterations;
    learn_L();
    step();
    if (summary.iterations % kLook == 0 && !look(progress)) break;
    if (summary.iterations % kPatience == 0) {
      if (norm2 / (2 * L_) <= progress.cost_tolerance() * summary.cost && progress.decrease_is_small(patience_cost, summary.cost)) break;
      patience_cost = summary.cost;
    }
  }
  take_if_lower(summary);
  flat_.write(best_, values);
  evaluate_(graph_, resolved_, values, g_, &pool_);
  summary.gradient_norm = max_norm(g_);
}

void FlatDescent::learn_L() {
  if (has_last_) {
    double along = 0, across = 0;
    for (std::size_t i = 0; i < g_.size(); ++i) {
      const double dg = g_[i] - last_g_[i];
      along += dg * (y_[i] - last_y_[i]);
      across += dg * (d_[i] - last_d_[i]);
    }
    L_ = std::max(kLeastL, kForget * L_);
    if (along > 0) L_ = std::max(L_, across / along);
  }
  std::swap(last_g_, g_);
  std::swap(last_d_, d_);
  has_last_ = true;
}

// From here the gradient and direction are last_g_ and last_d_.
void FlatDescent::step() {
  const double t_next = (1 + std::sqrt(1 + 4 * t_ * t_)) / 2, beta = (t_ - 1) / t_next, length = 1 / L_;
  double uphill = 0;
  for (std::size_t i = 0; i < x_.size(); ++i) {
    const double next = y_[i] - length * last_d_[i], move = next - x_[i];
    uphill += last_g_[i] * move;
    x_[i] = next;
    last_y_[i] = y_[i];
    y_[i] = next + beta * move;
  }
  t_ = t_next;
  if (uphill > 0) {
    y_ = x_;
    t_ = 1;
  }
}

bool FlatDescent::take_if_lower(Summary& summary) {
  flat_.write(x_, at_);
  const double cost = resolved_.cost(graph_, at_, &pool_);
  if (cost < summary.cost) {
    summary.cost = cost;
    best_ = x_;
  }
  return cost <= summary.cost;
}

bool FlatDescent::look(Progress& progress) {
  if (take_if_lower(progress.summary)) return true;
  if (L_ > kMostL) {
    progress.end(Termination::converged, "no step, however short, lowers the cost");
    return false;
  }
  x_ = y_ = best_;
  t_ = 1;
  has_last_ = false;
  L_ *= 2;
  return true;
}

}  // namespace holdfast::detail
