#include <algorithm>
#include <filesystem>
#include <holdfast/benchmarks/bench_runner.hpp>
#include <holdfast/common/drawing.hpp>
#include <holdfast/common/log.hpp>
#include <holdfast/common/machine.hpp>
#include <holdfast/graph/files/atomic.hpp>
#include <limits>
#include <optional>

namespace holdfast::bench {
namespace {

/// What two lines have in common that are of the same run.
std::string identity(const Json& line) {
  std::string text;
  for (const char* field :
       {"suite", "file", "loss", "start", "backend", "seed", "threads", "tolerance", "max_iterations", "time_limit", "commit", "machine"})
    text += line.value(field, Json()).dump(-1, ' ', false, Json::error_handler_t::replace) + '|';
  return text;
}

std::vector<Run> runs_of(const Suite& suite, const Case& one, const std::vector<Entrant>& entrants, const RunnerOptions& options) {
  std::vector<Run> runs;
  for (const Entrant& entrant : entrants) {
    Task& task = runs.emplace_back().task;
    task = {one.name, one.loss, one.start, entrant.backend, options.seed, options.solver};
    task.options.threads = entrant.threads;
    task.options.max_iterations = suite.max_iterations;
  }
  return runs;
}

}  // namespace

std::vector<Entrant> entrants_of(const std::vector<std::string>& backends, int threads) {
  std::vector<Entrant> entrants;
  for (const std::string& backend : backends) entrants.push_back({backend, threads});
  return entrants;
}

Json Runner::line_of(const Run& run) const {
  Json line = to_json(run);
  line["suite"] = suite_.name;
  line["commit"] = commit();
  line["machine"] = machine();
  return line;
}

// The latest line of each run counts.
std::vector<Json> Runner::known_lines(const std::vector<Run>& wanted) const {
  std::vector<Json> lines(wanted.size());
  if (options_.fresh) return lines;
  const auto& known = journal_.lines();
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string identity_wanted = identity(line_of(wanted[i]));
    const auto found = std::find_if(known.rbegin(), known.rend(), [&](const Json& line) { return identity(line) == identity_wanted; });
    if (found != known.rend()) lines[i] = *found;
  }
  const bool some_missing = std::any_of(lines.begin(), lines.end(), [](const Json& line) { return line.is_null(); });
  return policy_.in_one_run && some_missing ? std::vector<Json>(lines.size()) : lines;
}

// Every entrant once, with its trace, then those that were fast again, in turn.
void Runner::repeat(std::vector<Run*>& runs, const Instance& instance) {
  Values answer, drawn_answer;
  std::optional<Run> drawn;
  double least = std::numeric_limits<double>::infinity();
  for (Run* run : runs) {
    Task task = run->task;
    bar_.begin(task.file + " " + task.loss + " " + task.backend);
    task.options.progress = bar_.callback();
    task.options.trace = true;
    *run = run_task(task, instance, answer);
    run->task.options.progress = nullptr;
    run->task.options.trace = false;
    if (run->summary.usable() && run->summary.cost < least) {
      least = run->summary.cost;
      drawn = *run;
      drawn_answer = answer;
    }
    bar_.done_with_one();
  }
  for (int i = 1; i < options_.repetitions; ++i)
    for (Run* run : runs)
      if (run->seconds.front() < kFast && run->summary.usable())
        run->seconds.push_back(run_task(run->task, instance, answer).summary.seconds);
  if (drawn) write_drawing(*drawn, instance, drawn_answer);
}

// Beside the results, not in them: they are large, and say nothing that a table shows.
void Runner::write_drawing(const Run& run, const Instance& instance, const Values& answer) const {
  constexpr std::size_t kMost = 4000;
  namespace fs = std::filesystem;
  const Task& task = run.task;
  Json json = to_json(drawing_of(instance.graph, instance.truth, answer, kMost));
  json["suite"] = suite_.name;
  json["file"] = task.file;
  json["loss"] = task.loss;
  json["start"] = task.start;
  json["backend"] = task.backend;
  json["cost"] = run.summary.cost;
  json["seed"] = task.seed;
  json["commit"] = commit();
  std::string name = std::string(suite_.name) + "_" + fs::path(task.file).stem().string() + "_" + task.loss + "_" + task.start;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '/' || c == ' ' || c == ':'; }, '-');
  const fs::path folder = fs::path(journal_.path()).parent_path() / "drawings";
  std::error_code error;
  fs::create_directories(folder, error);  // where it fails, atomic_write says why
  atomic_write((folder / (name + ".json")).string(), to_line(json));
}

void Runner::run(const Case& one, const std::vector<Entrant>& entrants, SuiteResult& result) {
  const std::string name = one.name + " (" + one.*policy_.said_of_case + "): ";
  if (!one.absent.empty()) {
    result.skipped.push_back(name + one.absent);
    return;
  }
  std::vector<Run> runs = runs_of(suite_, one, entrants, options_);
  std::vector<Json> lines = known_lines(runs);
  std::vector<Run*> missing;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].is_null())
      missing.push_back(&runs[i]);
    else
      ++result.taken, bar_.done_with_one();
  }
  if (!missing.empty()) {
    try {
      repeat(missing, one.make());
    } catch (const Error& error) {  // one bad file does not stop the suite
      result.broken.push_back(name + error.what());
      return;
    }
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (!lines[i].is_null()) continue;
      lines[i] = line_of(runs[i]);
      journal_.append(lines[i]);
      log(std::string(suite_.name) + " " + one.name + " " + runs[i].task.backend + ": " + runs[i].summary.str());
    }
  }
  result.lines.insert(result.lines.end(), lines.begin(), lines.end());
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

}  // namespace holdfast::bench
