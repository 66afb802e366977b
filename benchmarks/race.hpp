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

/// The race of `holdfast bench window`, a line a row: windows made from the seeds options.seed, options.seed + 1, …
std::vector<Json> window_lines(const RunnerOptions& options, unsigned windows, ProgressBar& bar);

/// Seconds of the fastest other back-end whose cost is within kSameCost of the best found, over those of `irls`; NaN where there is none.
double lead(const Json& irls, const std::vector<Json>& lines);

/// A row a run, problem by problem; says of each run that ended above the best cost found by how much.
void print_race(std::ostream& out, const std::vector<Json>& lines);

/// The suite's name, rules and machine.
void print_head(std::ostream& out, const Suite& suite, const std::string& rules);

}  // namespace holdfast::bench
