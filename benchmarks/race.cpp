#include <algorithm>
#include <holdfast/benchmarks/race.hpp>
#include <holdfast/common/machine.hpp>
#include <holdfast/common/report.hpp>
#include <holdfast/common/table.hpp>
#include <holdfast/solvers/table.hpp>

namespace holdfast::bench {
namespace {

bool same_problem(const Json& a, const Json& b) { return a["file"] == b["file"] && a["loss"] == b["loss"] && a["start"] == b["start"]; }

/// Relative to the lowest cost any run of the same problem ended at.
double above_best(const Json& run, const std::vector<Json>& lines) {
  if (!run["cost"].is_number()) return std::numeric_limits<double>::infinity();
  double best = run["cost"];
  for (const Json& other : lines)
    if (same_problem(run, other) && other["cost"].is_number()) best = std::min(best, other["cost"].get<double>());
  return (run["cost"].get<double>() - best) / std::max(std::abs(best), std::numeric_limits<double>::min());
}

double number(const Json& json) { return json.is_number() ? json.get<double>() : std::numeric_limits<double>::quiet_NaN(); }

std::string label(const Json& run) {
  const std::string backend = run["backend"];
  return run["threads"] == 1 ? backend : backend + ", " + run["threads"].dump() + " threads";
}

std::string remark(const Json& run, double above) {
  if (run["termination"] == "failed") return "failed: " + run["why"].get<std::string>();
  std::string remark = run["termination"] == "converged" ? "" : run["termination"].get<std::string>();
  if (run.value("restarts", 0) > 0) remark += (remark.empty() ? "" : ", ") + std::string("with a chordal restart");
  if (above > kSameCost) remark += (remark.empty() ? "" : ", ") + std::string("NOT the best cost: ") + cell("%+.2g", above) + " of it";
  return remark;
}

bool begins_with(const std::string& text, const char* start) { return text.rfind(start, 0) == 0; }

}  // namespace

std::vector<std::string> race_backends() {
  std::vector<std::string> chosen;
  for (const std::string& name : backend_names())
    if (name == "irls" || begins_with(name, "ceres") || begins_with(name, "gtsam") || begins_with(name, "g2o")) chosen.push_back(name);
  return chosen;
}

RunnerOptions race_options(const RunnerOptions& asked) {
  RunnerOptions options = asked;
  options.backends = race_backends();
  options.solver.cost_tolerance = 1e-6;
  options.solver.threads = 1;
  options.repetitions = std::max(5, asked.repetitions);
  return options;
}

double lead(const Json& irls, const std::vector<Json>& lines) {
  double fastest = std::numeric_limits<double>::infinity();
  for (const Json& other : lines)
    if (same_problem(irls, other) && other["backend"] != "irls" && other["termination"] != "failed" &&
        above_best(other, lines) <= kSameCost)
      fastest = std::min(fastest, number(other["seconds"]));
  return std::isfinite(fastest) ? fastest / number(irls["seconds"]) : std::numeric_limits<double>::quiet_NaN();
}

void print_race(std::ostream& out, const std::vector<Json>& lines) {
  constexpr auto left = Table::Align::left, right = Table::Align::right;
  Table table({{"problem", left},
               {"start", left},
               {"back-end", left},
               {"seconds", right},
               {"iterations", right},
               {"cost", right},
               {"above best", right},
               {"best peer/irls", right},
               {"", left}});
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Json& run = lines[i];
    const bool first = i == 0 || !same_problem(run, lines[i - 1]);
    const double above = above_best(run, lines);
    table.add({first ? run["file"].get<std::string>() : "", first ? run["start"].get<std::string>() : "", label(run),
               cell("%.5f", number(run["seconds"])), cell("%.0f", number(run["iterations"])), cell("%.8g", number(run["cost"])),
               cell("%.1e", above), run["backend"] == "irls" ? cell("%.2f", lead(run, lines)) : "", remark(run, above)});
  }
  table.print(out);
}

void print_head(std::ostream& out, const Suite& suite, const std::string& rules) {
  out << "== " << suite.name << ": " << suite.what << '\n'
      << rules << " --backend, --tolerance and --threads do not change a race. Commit " << commit() << ", "
      << machine()["cpu"].get<std::string>() << ", " << machine()["cores"] << " cores.\n"
      << std::flush;
}

}  // namespace holdfast::bench
