#include <algorithm>
#include <cmath>
#include <holdfast/solvers/internal/minimizer.hpp>

namespace holdfast {

bool Progress::begin(double cost) {
  summary.cost_first = summary.cost = cost;
  if (std::isfinite(cost)) return true;
  end(Termination::failed, "the cost at the start is not finite");
  return false;
}

bool Progress::begin(double cost, const Graph& graph, const Resolved& resolved, const Values& values) {
  if (begin(cost)) return true;
  summary.culprit = resolved.first_non_finite(graph, values).text;
  return false;
}

bool Progress::report(double gradient_norm) {
  summary.gradient_norm = gradient_norm;
  if (!options_.trace && !options_.progress) return true;
  const Iteration iteration{summary.iterations, std::min(summary.cost, best_elsewhere), gradient_norm, watch.seconds()};
  if (options_.trace) summary.trace.push_back(iteration);
  return !options_.progress || options_.progress(iteration);
}

bool Progress::go_on(double gradient_norm) {
  if (!try_on(gradient_norm)) return false;
  if (summary.iterations < max_iterations_) return true;
  end(Termination::iteration_limit, "max_iterations reached");
  return false;
}

bool Progress::try_on(double gradient_norm) {
  enum { goes_on, is_late, is_stopped };
  double what = !report(gradient_norm) ? is_stopped : watch.seconds() > options_.time_limit ? is_late : goes_on;
  if (largest_of_all) what = largest_of_all(what);
  if (what == is_stopped) end(Termination::stopped, "the progress callback asked to stop");
  if (what == is_late) end(Termination::time_limit, "time_limit reached");
  return what == goes_on;
}

bool Progress::gradient_is_flat(double gradient_norm) {
  if (!(gradient_norm <= options_.gradient_tolerance)) return false;
  end(Termination::converged, "the gradient is within gradient_tolerance");
  return true;
}

bool Progress::decrease_is_small(double cost_before, double cost) {
  if (!(cost_before - cost <= options_.cost_tolerance * cost_before)) return false;
  end(Termination::converged, "the relative decrease of the cost is within cost_tolerance");
  return true;
}

double max_norm(const std::vector<double>& v) {
  double largest = 0;
  for (double x : v) {
    if (std::isnan(x)) return x;
    largest = std::max(largest, std::abs(x));
  }
  return largest;
}

}  // namespace holdfast
