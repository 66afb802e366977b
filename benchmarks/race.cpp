#include <algorithm>
#include <cstdio>
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

std::string text(const char* format, double number) {
  if (!std::isfinite(number)) return "-";
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, format, number);
  return buffer;
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
  if (above > kSameCost) remark += (remark.empty() ? "" : ", ") + std::string("NOT the best cost: ") + text("%+.2g", above) + " of it";
  return remark;
}

Json line_of(const Suite& suite, const Run& run) {
  Json line = to_json(run);
  line["suite"] = suite.name;
  line["commit"] = commit();
  line["machine"] = machine();
  return line;
}

bool same_run(const Json& a, const Json& b) {
  for (const char* field :
       {"suite", "file", "loss", "start", "backend", "seed", "threads", "tolerance", "max_iterations", "time_limit", "commit", "machine"})
    if (a.value(field, Json()) != b.value(field, Json())) return false;
  return true;
}

/// The latest line of each run; empty where one is missing.
std::vector<Json> known_lines(const Suite& suite, const std::vector<Run>& runs, const Journal& journal) {
  std::vector<Json> lines;
  for (const Run& run : runs) {
    const Json wanted = line_of(suite, run);
    const auto& known = journal.lines();
    const auto found = std::find_if(known.rbegin(), known.rend(), [&](const Json& line) { return same_run(line, wanted); });
    if (found == known.rend()) return {};
    lines.push_back(*found);
  }
  return lines;
}

void repeat(std::vector<Run>& runs, const Instance& instance, int repetitions, ProgressBar& bar) {
  Values answer;
  for (Run& run : runs) {
    Task task = run.task;
    bar.begin(task.file + " " + task.backend);
    task.options.progress = bar.callback();
    run = run_task(task, instance, answer);
    run.task.options.progress = nullptr;
    bar.done_with_one();
  }
  for (int i = 1; i < repetitions; ++i)
    for (Run& run : runs)
      if (run.seconds.front() < kFast && run.summary.usable()) run.seconds.push_back(run_task(run.task, instance, answer).summary.seconds);
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

std::vector<Entrant> single_threaded(const std::vector<std::string>& backends) {
  std::vector<Entrant> entrants;
  for (const std::string& backend : backends) entrants.push_back({backend, 1});
  return entrants;
}

void race_case(const Suite& suite, const Case& one, const std::vector<Entrant>& entrants, const RunnerOptions& options, Journal& journal,
               ProgressBar& bar, SuiteResult& result) {
  if (!one.absent.empty()) {
    result.skipped.push_back(one.name + " (" + one.start + "): " + one.absent);
    return;
  }
  std::vector<Run> runs;
  for (const Entrant& entrant : entrants) {
    runs.emplace_back().task = {one.name, one.loss, one.start, entrant.backend, options.seed, options.solver};
    runs.back().task.options.threads = entrant.threads;
    runs.back().task.options.max_iterations = suite.max_iterations;
  }
  std::vector<Json> lines = options.fresh ? std::vector<Json>() : known_lines(suite, runs, journal);
  if (lines.empty()) {
    try {
      repeat(runs, one.make(), options.repetitions, bar);
    } catch (const Error& error) {  // one bad file does not stop the suite
      result.broken.push_back(one.name + " (" + one.start + "): " + error.what());
      return;
    }
    for (const Run& run : runs) {
      lines.push_back(line_of(suite, run));
      journal.append(lines.back());
    }
  } else {
    result.taken += lines.size();
  }
  result.lines.insert(result.lines.end(), lines.begin(), lines.end());
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
               text("%.5f", number(run["seconds"])), text("%.0f", number(run["iterations"])), text("%.8g", number(run["cost"])),
               text("%.1e", above), run["backend"] == "irls" ? text("%.2f", lead(run, lines)) : "", remark(run, above)});
  }
  table.print(out);
}

bool print_end(Terminal& terminal, const SuiteResult& result, const std::string& path) {
  for (const std::string& skipped : result.skipped) terminal.out << "skipped " << skipped << '\n';
  if (result.taken > 0)
    terminal.out << result.taken << " runs were there already (same commit, machine, options and seed); --fresh runs them again\n";
  if (!result.lines.empty()) terminal.out << "results: " << path << '\n';
  terminal.out << std::endl;
  for (const std::string& broken : result.broken) terminal.err << "holdfast: " << broken << '\n';
  const bool none_failed =
      std::none_of(result.lines.begin(), result.lines.end(), [](const Json& line) { return line["termination"] == "failed"; });
  return result.broken.empty() && none_failed;
}

void print_head(std::ostream& out, const Suite& suite, const std::string& rules) {
  out << "== " << suite.name << ": " << suite.what << '\n'
      << rules << " --backend, --tolerance and --threads do not change a race. Commit " << commit() << ", "
      << machine()["cpu"].get<std::string>() << ", " << machine()["cores"] << " cores.\n"
      << std::flush;
}

}  // namespace holdfast::bench
