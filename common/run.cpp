#include <algorithm>
#include <holdfast/common/run.hpp>
#include <holdfast/solvers/table.hpp>

namespace holdfast::common {
namespace {

Summary refused(const std::exception& error) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  Summary summary;
  summary.rule = "the problem cannot be solved";
  summary.culprit = error.what();
  summary.cost_first = summary.cost = summary.gradient_norm = kNone;
  return summary;
}

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

/// [[seconds, cost], …]: the first iterations, then every one that is a few per cent later than the last.
Json trace_json(const std::vector<Iteration>& trace) {
  constexpr std::size_t kFirst = 100;
  constexpr double kLater = 1.03;
  Json points = Json::array();
  double next = 0;
  for (std::size_t i = 0; i < trace.size(); ++i) {
    if (i >= kFirst && i + 1 < trace.size() && trace[i].seconds < next) continue;
    next = kLater * trace[i].seconds;
    points.push_back({number(trace[i].seconds), number(trace[i].cost)});
  }
  return points;
}

}  // namespace

Run run_task(const Task& task, const Instance& instance, Values& answer) {
  Run run;
  run.task = task;
  run.variables = instance.start.size();
  run.factors = instance.graph.size();
  answer = instance.start;
  try {
    run.summary = make_backend(task.backend, task.options)->solve(instance.graph, answer);
  } catch (const std::exception& error) {
    run.summary = refused(error);
  }
  run.seconds = {run.summary.seconds};
  if (run.summary.usable()) {
    run.error = position_error(instance.truth, answer);
    run.rejected = count_rejected(instance.graph, answer);
  }
  return run;
}

double median(std::vector<double> numbers) {
  if (numbers.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(numbers.begin(), numbers.end());
  const std::size_t middle = numbers.size() / 2;
  return numbers.size() % 2 == 1 ? numbers[middle] : (numbers[middle - 1] + numbers[middle]) / 2;
}

double percentile_95(std::vector<double> numbers) {
  if (numbers.empty()) return std::numeric_limits<double>::quiet_NaN();
  const std::size_t place = (numbers.size() * 95 + 99) / 100 - 1;
  std::nth_element(numbers.begin(), numbers.begin() + static_cast<std::ptrdiff_t>(place), numbers.end());
  return numbers[place];
}

Json to_json(const Run& run) {
  const Task& task = run.task;
  const Summary& s = run.summary;
  Json json;
  json["file"] = task.file;
  json["backend"] = task.backend;
  json["loss"] = task.loss;
  json["start"] = task.start;
  json["cost_first"] = number(s.cost_first);
  json["cost"] = number(s.cost);
  json["iterations"] = s.iterations;
  json["restarts"] = s.restarts;
  json["termination"] = to_string(s.termination);
  json["why"] = s.why();
  json["gradient_norm"] = number(s.gradient_norm);
  json["seconds"] = number(median(run.seconds));
  json["seconds_setup"] = number(s.seconds_setup);
  json["seconds_linearize"] = number(s.seconds_linearize);
  json["seconds_solve"] = number(s.seconds_solve);
  json["repetitions"] = run.seconds.size();
  json["ate_rmse"] = run.error ? number(run.error->ate_rmse) : Json(nullptr);
  json["rmse"] = run.error ? number(run.error->rmse) : Json(nullptr);
  json["rejected_ranges"] = s.usable() ? Json(run.rejected.rejected_ranges) : Json(nullptr);
  json["ranges"] = s.usable() ? Json(run.rejected.ranges) : Json(nullptr);
  json["rejected_factors"] = s.usable() ? Json(run.rejected.rejected) : Json(nullptr);
  json["judged"] = s.usable() ? Json(run.rejected.judged) : Json(nullptr);
  json["variables"] = run.variables;
  json["factors"] = run.factors;
  json["seed"] = task.seed;
  json["threads"] = task.options.threads;
  json["tolerance"] = number(task.options.cost_tolerance);
  json["max_iterations"] = task.options.max_iterations;
  json["time_limit"] = number(task.options.time_limit);
  if (!s.trace.empty()) json["trace"] = trace_json(s.trace);
  return json;
}

std::string to_line(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace) + '\n'; }

}  // namespace holdfast::common
