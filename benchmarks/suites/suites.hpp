// The suites of `holdfast bench`. A new one is a function that lists its cases, and one line in the table of suites.cpp.
#pragma once

#include <functional>
#include <holdfast/common/instance.hpp>
#include <holdfast/common/terminal.hpp>
#include <string>
#include <vector>

namespace holdfast::bench {

using namespace common;

struct RunnerOptions;
class Journal;

struct Suite {
  const char* name;
  const char* what;
  bool by_default;     ///< runs when no suite is named
  int max_iterations;  ///< the same for every back-end
  std::function<std::vector<Case>(unsigned seed)> cases;
  /// Set: a race, which chooses back-ends, threads and tolerance itself, runs and prints itself. False where a run failed.
  bool (*race)(const RunnerOptions& options, Journal& journal, Terminal& terminal) = nullptr;
};

const std::vector<Suite>& suites();
/// Those named, or the default ones. Throws BadOption listing the names.
std::vector<Suite> suites_of(const std::vector<std::string>& names);

std::vector<Case> scenario_cases(unsigned seed);
std::vector<Case> data_cases(unsigned seed);
std::vector<Case> range_cases(unsigned seed);
std::vector<Case> pose_graph_cases(unsigned seed);

bool race_windows(const RunnerOptions& options, Journal& journal, Terminal& terminal);
bool race_ranges(const RunnerOptions& options, Journal& journal, Terminal& terminal);
bool race_pose_graphs(const RunnerOptions& options, Journal& journal, Terminal& terminal);
bool race_networks(const RunnerOptions& options, Journal& journal, Terminal& terminal);
bool race_robust(const RunnerOptions& options, Journal& journal, Terminal& terminal);
bool race_incremental(const RunnerOptions& options, Journal& journal, Terminal& terminal);
bool race_online(const RunnerOptions& options, Journal& journal, Terminal& terminal);

/// Where the research data is ($HOLDFAST_DATA, or shared/data beside the source tree or the working directory); "" where it is not.
std::string data_directory();
/// A file of that directory as a case; start: "file", "odometry" or "chordal".
Case data_case(const std::string& file, const std::string& loss, const std::string& start, unsigned seed);

/// A walk on the unit grid: straight on, or (3 steps in 10, and at a wall) a quarter turn, then 1 m ahead; `poses` poses `x<k>` in a square
/// hall (space 2) or in one of three floors (space 3) with a cell for three poses. Where the walk has been before, every second pose sees
/// one of the earlier ones there. σ = 0.05 m per axis, 0.02 rad. The first pose is fixed. Start: truth + N(0, 0.1 m) and N(0, 0.05 rad), so
/// that graphs of all sizes need about the same number of iterations.
Instance grid_walk(int space, int poses, unsigned seed);

}  // namespace holdfast::bench
