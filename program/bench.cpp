#include <CLI/CLI.hpp>
#include <filesystem>
#include <holdfast/benchmarks/bench_runner.hpp>
#include <holdfast/common/machine.hpp>
#include <holdfast/common/report.hpp>
#include <holdfast/program/output.hpp>
#include <holdfast/program/program.hpp>

namespace holdfast::program {

namespace fs = std::filesystem;

CLI::App* add_bench(CLI::App& app, BenchArguments& arguments) {
  CLI::App* command =
      app.add_subcommand("bench", "run suites of problems, print tables, keep every run as a line of JSON; goes on where it was killed");
  std::string names;
  for (const Suite& suite : suites())
    names += std::string("\n  ") + suite.name + ": " + suite.what + (suite.by_default ? " (default)" : "");
  command->add_option("SUITE", arguments.suites, "of:" + names);
  command->add_option("--out", arguments.out, "directory of the results, a file <suite>.jsonl each")->capture_default_str();
  command->add_option("--backend", arguments.backends, "comma-separated names, or all")->capture_default_str();
  command->add_option("--threads", arguments.threads)->capture_default_str();
  command->add_option("--tolerance", arguments.tolerance, "relative decrease of the cost that ends a solve")->capture_default_str();
  command->add_option("--time-limit", arguments.time_limit, "seconds a solve")->capture_default_str();
  command->add_option("--repetitions", arguments.repetitions, "of a solve that takes less than a second")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  command->add_option("--seed", arguments.seed)->capture_default_str();
  command->add_option("--runs", arguments.runs, "seeds of the papers' suites (20) and of robust (10): SEED, SEED + 1, …")
      ->check(CLI::PositiveNumber);
  command->add_flag("--fresh", arguments.fresh, "run again what the results hold already");
  command->add_option("--graphs", arguments.graphs, "of robust and incremental: these alone, such as intel,plaza2")->delimiter(',');
  command->add_option("--kinds", arguments.kinds, "of robust: these outliers alone, such as random,\"at one place\",echoes")
      ->delimiter(',');
  command->add_option("--shares", arguments.shares, "of robust: these alone, such as 0.1,3")->delimiter(',');
  command->add_option("--methods", arguments.methods, "of robust: these alone, such as gnc-irls,\"pcm + gnc-irls\"")->delimiter(',');
  command->add_option("--sizes", arguments.sizes, "of network: numbers of nodes, comma-separated, such as 1000,1000000")
      ->delimiter(',')
      ->check(CLI::Range(10, 10000000));
  command->add_option("--write", arguments.write_to, "of robust: a directory for its pose graphs as g2o files, for benchmarks/peers");
  add_json(*command, arguments.json, "the lines of this commit of the suites that were run, those of the results' files, once more");
  add_examples(*command, {"holdfast bench", "holdfast bench scenarios --backend irls,ceres --out before",
                          "holdfast bench robust --graphs intel --kinds random --shares 0.1 --runs 3"});
  return command;
}

namespace {

RunnerOptions runner_options(const BenchArguments& arguments) {
  RunnerOptions options;
  options.backends = backends_of(arguments.backends);
  options.solver.threads = arguments.threads;
  options.solver.cost_tolerance = arguments.tolerance;
  options.solver.time_limit = arguments.time_limit;
  options.solver.validate();
  options.repetitions = arguments.repetitions;
  options.seed = arguments.seed;
  options.runs_are_asked = arguments.runs > 0;
  if (options.runs_are_asked) options.runs = arguments.runs;
  options.graphs = arguments.graphs;
  options.kinds = arguments.kinds;
  options.methods = arguments.methods;
  options.shares = arguments.shares;
  options.sizes = arguments.sizes;
  options.write_to = arguments.write_to;
  options.fresh = arguments.fresh;
  return options;
}

void print_rules(std::ostream& out, const Suite& suite, const RunnerOptions& options) {
  out << "== " << suite.name << ": " << suite.what << "\n"
      << "Same start, same cost function (Graph::cost) and same stopping rule for all: a step that lowers the cost by less than "
      << options.solver.cost_tolerance << " of it, or " << suite.max_iterations << " iterations, or " << options.solver.time_limit
      << " s.\n";
  out << "Seed " << options.seed << ", threads " << options.solver.threads << ", seconds: the whole solve() call, median of "
      << options.repetitions << " in turn where it takes less than " << kFast << " s, else one. Commit " << commit() << ", "
      << machine()["cpu"].get<std::string>() << ", " << machine()["cores"] << " cores.\n";
}

/// A suite that is no race: every case under every back-end. False where a run is broken or failed.
bool run_suite(const Suite& suite, const RunnerOptions& options, Journal& journal, Terminal& terminal) {
  print_rules(terminal.out, suite, options);
  terminal.out.flush();
  const std::vector<Case> cases = suite.cases(options.seed);
  ProgressBar bar(terminal, cases.size() * options.backends.size());
  Runner runner(suite, kSuitePolicy, options, journal, bar);
  SuiteResult result;
  for (const Case& one : cases) runner.run(one, entrants_of(options.backends, options.solver.threads), result);
  bar.clear();
  if (!result.lines.empty()) print_suite(terminal.out, result.lines);
  print_differences(terminal.out, result.lines);
  return print_end(terminal, result, journal.path());
}

}  // namespace

int bench(const BenchArguments& arguments, Terminal& terminal) {
  check_json(arguments.json);
  const std::vector<Suite> chosen = suites_of(arguments.suites);
  const RunnerOptions options = runner_options(arguments);
  const bool of_robust = !(options.kinds.empty() && options.methods.empty() && options.shares.empty() && options.write_to.empty());
  for (const Suite& suite : chosen) {
    const std::string name = suite.name;
    if (of_robust && name != "robust")
      fail<BadOption>("--kinds, --shares, --methods and --write are options of the suite robust alone; ", name, " has none of them");
    if (!options.graphs.empty() && name != "robust" && name != "incremental")
      fail<BadOption>("--graphs is an option of the suites robust and incremental; ", name, " does not have it");
    if (!options.sizes.empty() && name != "network")
      fail<BadOption>("--sizes is an option of the suite network alone; ", name, " does not have it");
  }
  std::error_code error;
  fs::create_directories(arguments.out, error);
  if (error) fail<BadFile>("cannot make the directory ", arguments.out, ": ", error.message(), "; give another with --out");
  bool all_is_well = true;
  std::vector<Json> lines;
  for (const Suite& suite : chosen) {
    Journal journal((fs::path(arguments.out) / (std::string(suite.name) + ".jsonl")).string());
    const bool is_well = suite.race != nullptr ? suite.race(options, journal, terminal) : run_suite(suite, options, journal, terminal);
    all_is_well = all_is_well && is_well;
    for (const Json& line : journal.lines())
      if (line.value("commit", "") == commit()) lines.push_back(line);
  }
  write_json(arguments.json, lines, terminal);
  return all_is_well ? kDone : kFailed;
}

}  // namespace holdfast::program
