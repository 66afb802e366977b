#include <holdfast/benchmarks/race.hpp>

namespace holdfast::bench {

std::vector<Case> range_cases(unsigned seed) {
  std::vector<Case> cases;
  for (const char* name : {"plaza2", "single_drone", "mrclam5a", "tiers"})
    cases.push_back(data_case("range/" + std::string(name) + ".pyfg", "squared", "odometry", seed));
  return cases;
}

bool race_ranges(const RunnerOptions& asked, Journal& journal, Terminal& terminal) {
  const Suite suite = suites_of({"range"}).front();
  const RunnerOptions options = race_options(asked);
  print_head(terminal.out, suite,
             "Squared loss, odometry start (seed " + std::to_string(options.seed) +
                 "), tolerance 1e-6, one thread; the whole solve() of a " + "fresh back-end object, setup and all, median of " +
                 std::to_string(options.repetitions) + " in turn.");
  const std::vector<Case> cases = suite.cases(options.seed);
  ProgressBar bar(terminal, cases.size() * options.backends.size());
  Runner runner(suite, kRacePolicy, options, journal, bar);
  SuiteResult result;
  for (const Case& one : cases) runner.run(one, entrants_of(options.backends, 1), result);
  bar.clear();
  print_race(terminal.out, result.lines);
  return print_end(terminal, result, journal.path());
}

}  // namespace holdfast::bench
