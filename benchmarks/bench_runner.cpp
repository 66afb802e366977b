#include <algorithm>
#include <holdfast/benchmarks/bench_runner.hpp>
#include <holdfast/common/log.hpp>
#include <holdfast/common/machine.hpp>

namespace holdfast::bench {
namespace {

Task task_of(const Suite& suite, const Case& one, const std::string& backend, const RunnerOptions& options) {
  Task task{one.name, one.loss, one.start, backend, options.seed, options.solver};
  task.options.max_iterations = suite.max_iterations;
  return task;
}

Json line_of(const Suite& suite, const Run& run) {
  Json line = to_json(run);
  line["suite"] = suite.name;
  line["commit"] = commit();
  line["machine"] = machine();
  return line;
}

/// What two lines have in common that are of the same run.
std::string identity(const Json& line) {
  std::string text;
  for (const char* field :
       {"suite", "file", "loss", "start", "backend", "seed", "threads", "tolerance", "max_iterations", "time_limit", "commit", "machine"})
    text += line.value(field, Json()).dump(-1, ' ', false, Json::error_handler_t::replace) + '|';
  return text;
}

/// Every back-end once, then those that were fast again, in turn: what slows the machine down for a while hits all of them.
std::vector<Run> race(const std::vector<Task>& tasks, const Instance& instance, int repetitions, ProgressBar& bar) {
  std::vector<Run> runs;
  Values answer;
  for (Task task : tasks) {
    bar.begin(task.file + " " + task.loss + " " + task.backend);
    task.options.progress = bar.callback();
    runs.push_back(run_task(task, instance, answer));
    bar.done_with_one();
  }
  for (int i = 1; i < repetitions; ++i)
    for (Run& run : runs) {
      if (run.seconds.front() >= kFast || !run.summary.usable()) continue;
      run.seconds.push_back(run_task(run.task, instance, answer).summary.seconds);
    }
  return runs;
}

/// The lines of one case, in the order of the back-ends; made where they are missing.
void run_case(const Suite& suite, const Case& one, const RunnerOptions& options, Journal& journal, ProgressBar& bar, SuiteResult& result) {
  std::vector<Json> lines(options.backends.size());
  std::vector<Task> tasks;
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Task task = task_of(suite, one, options.backends[i], options);
    Run wanted;
    wanted.task = task;
    const std::string identity_wanted = identity(line_of(suite, wanted));
    const auto& known = journal.lines();
    const auto found = std::find_if(known.rbegin(), known.rend(), [&](const Json& line) { return identity(line) == identity_wanted; });
    if (found != known.rend() && !options.fresh) {
      lines[i] = *found;
      ++result.taken;
      bar.done_with_one();
    } else {
      tasks.push_back(task);
      places.push_back(i);
    }
  }
  if (!tasks.empty()) {
    Instance instance;
    try {
      instance = one.make();
    } catch (const Error& error) {  // one bad file does not stop the suite
      result.broken.push_back(one.name + " (" + one.loss + "): " + error.what());
      return;
    }
    const std::vector<Run> runs = race(tasks, instance, options.repetitions, bar);
    for (std::size_t k = 0; k < runs.size(); ++k) {
      lines[places[k]] = line_of(suite, runs[k]);
      journal.append(lines[places[k]]);
      log(std::string(suite.name) + " " + one.name + " " + runs[k].task.backend + ": " + runs[k].summary.str());
    }
  }
  result.lines.insert(result.lines.end(), lines.begin(), lines.end());
}

}  // namespace

SuiteResult run_suite(const Suite& suite, const RunnerOptions& options, Journal& journal, ProgressBar& bar) {
  SuiteResult result;
  for (const Case& one : suite.cases(options.seed)) {
    if (!one.absent.empty()) {
      result.skipped.push_back(one.name + " (" + one.loss + "): " + one.absent);
      continue;
    }
    run_case(suite, one, options, journal, bar, result);
  }
  return result;
}

}  // namespace holdfast::bench
