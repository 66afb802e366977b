// Runs the cases of a suite under several back-ends, fairly, and goes on where an earlier call was killed.
#pragma once

#include <holdfast/benchmarks/journal.hpp>
#include <holdfast/benchmarks/suites/suites.hpp>
#include <holdfast/common/progress_bar.hpp>

namespace holdfast::bench {

using namespace common;

struct RunnerOptions {
  std::vector<std::string> backends;
  Options solver;       ///< the same for all
  int repetitions = 3;  ///< of a solve that takes less than kFast; the back-ends in turn
  unsigned seed = 1;
  unsigned runs = 20;  ///< of the papers' suites: seeds from `seed` on
  bool fresh = false;  ///< run again what is in the journal
};

/// Solves that take longer are run once [s].
inline constexpr double kFast = 1.0;

/// Same start, same cost, same stopping rule for every back-end. Each run's line goes to the journal as soon as its case is done; a run
/// whose line is there already (same problem, back-end, options, seed, commit and machine) is not run again. Returns the lines of the suite
/// in its order.
struct SuiteResult {
  std::vector<Json> lines;
  std::vector<std::string> skipped;  ///< cases whose data is absent, and why
  std::vector<std::string> broken;   ///< cases whose data is there, but bad, and why
  std::size_t taken = 0;             ///< lines that were in the journal
};
SuiteResult run_suite(const Suite& suite, const RunnerOptions& options, Journal& journal, ProgressBar& bar);

}  // namespace holdfast::bench
