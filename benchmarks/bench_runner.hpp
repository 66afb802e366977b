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
  unsigned runs = 20;           ///< of the papers' suites and of robust: seeds from `seed` on
  bool runs_are_asked = false;  ///< else a suite may have fewer of its own
  /// Of robust: these graphs, kinds of outliers, methods and shares alone; empty: all.
  std::vector<std::string> graphs, kinds, methods;
  std::vector<double> shares;
  std::vector<int> sizes;  ///< of network: nodes; empty: the suite's own
  std::string write_to;    ///< of robust: a directory that gets its problems as g2o files, for other programs; "": none
  bool fresh = false;      ///< run again what is in the journal
};

/// Solves that take longer are run once [s].
inline constexpr double kFast = 1.0;

struct Entrant {
  std::string backend;
  int threads = 1;
};
/// Each of these back-ends with so many threads.
std::vector<Entrant> entrants_of(const std::vector<std::string>& backends, int threads);

struct SuiteResult {
  std::vector<Json> lines;
  std::vector<std::string> skipped;  ///< cases whose data is absent, and why
  std::vector<std::string> broken;   ///< cases whose data is there, but bad, and why
  std::size_t taken = 0;             ///< lines that were in the journal
};

/// What tells a race from a suite.
struct Policy {
  /// Whether all lines of a case must be of one run: then they are taken from the journal only where it holds every one of them.
  bool in_one_run;
  std::string Case::*said_of_case;  ///< beside its name, where a case is skipped or broken
};
inline constexpr Policy kSuitePolicy{false, &Case::loss};
inline constexpr Policy kRacePolicy{true, &Case::start};

/// Same start, same cost, same stopping rule for every entrant, and a fresh back-end object for every repetition, so that seconds are
/// those of a first solve(), setup and all. The entrants in turn: what slows the machine down for a while hits all of them. Each run's line
/// goes to the journal as soon as its case is done; a run whose line is there already (same problem, back-end, options, seed, commit and
/// machine) is not run again.
class Runner {
 public:
  Runner(const Suite& suite, const Policy& policy, const RunnerOptions& options, Journal& journal, ProgressBar& bar)
      : suite_(suite), policy_(policy), options_(options), journal_(journal), bar_(bar) {}

  /// Its lines, in the order of the entrants, and what went wrong, go to `result`.
  void run(const Case& one, const std::vector<Entrant>& entrants, SuiteResult& result);

 private:
  /// A line of each entrant; null where it must be run.
  std::vector<Json> known_lines(const std::vector<Run>& wanted) const;
  Json line_of(const Run& run) const;
  void repeat(std::vector<Run*>& runs, const Instance& instance);
  /// drawings/<suite>_<problem>_<loss>_<start>.json beside the results: the best answer of a case (common/drawing.hpp).
  void write_drawing(const Run& run, const Instance& instance, const Values& answer) const;

  const Suite& suite_;
  Policy policy_;
  const RunnerOptions& options_;
  Journal& journal_;
  ProgressBar& bar_;
};

/// Prints what was skipped, broken or taken from the journal; false where a run is broken or failed.
bool print_end(Terminal& terminal, const SuiteResult& result, const std::string& path);

}  // namespace holdfast::bench
