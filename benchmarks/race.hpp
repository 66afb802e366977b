// A race: back-ends at their best setting on the same problems, side by side in one run, and how much faster ours is.
#pragma once

#include <holdfast/benchmarks/bench_runner.hpp>
#include <holdfast/common/terminal.hpp>

namespace holdfast::bench {

using namespace common;

/// ceres and its variants, irls, and gtsam and g2o, as far as this build has them.
std::vector<std::string> race_backends();

/// What a race makes of the options of the command line: its own back-ends, tolerance 1e-6, one thread, five repetitions or more.
RunnerOptions race_options(const RunnerOptions& asked);

struct Entrant {
  std::string backend;
  int threads = 1;
};
/// Each of these back-ends with one thread.
std::vector<Entrant> single_threaded(const std::vector<std::string>& backends);

/// One case under all entrants; its lines, and what went wrong, go to `result`. A fresh back-end object for every repetition, so that
/// seconds are those of a first solve(), setup and all; the entrants in turn. All lines are of one run: they are taken from the journal
/// only where it holds every one of them.
void race_case(const Suite& suite, const Case& one, const std::vector<Entrant>& entrants, const RunnerOptions& options, Journal& journal,
               ProgressBar& bar, SuiteResult& result);

/// The race of `holdfast bench window`, a line a row: windows made from the seeds options.seed, options.seed + 1, …
std::vector<Json> window_lines(const RunnerOptions& options, unsigned windows, ProgressBar& bar);

/// Seconds of the fastest other back-end whose cost is within kSameCost of the best found, over those of `irls`; NaN where there is none.
double lead(const Json& irls, const std::vector<Json>& lines);

/// A row a run, problem by problem; says of each run that ended above the best cost found by how much.
void print_race(std::ostream& out, const std::vector<Json>& lines);

/// Prints what was skipped, broken or taken from the journal; false where a run is broken or failed.
bool print_end(Terminal& terminal, const SuiteResult& result, const std::string& path);

/// The suite's name, rules and machine.
void print_head(std::ostream& out, const Suite& suite, const std::string& rules);

}  // namespace holdfast::bench
