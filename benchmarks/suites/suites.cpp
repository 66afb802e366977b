#include <algorithm>
#include <filesystem>
#include <holdfast/benchmarks/papers/paper.hpp>
#include <holdfast/benchmarks/suites/suites.hpp>

namespace holdfast::bench {
namespace fs = std::filesystem;
namespace {

/// Of a suite that makes its problems itself.
std::vector<Case> no_cases(unsigned) { return {}; }

}  // namespace

const std::vector<Suite>& suites() {
  static const std::vector<Suite> all{
      {"scenarios", "made from the seed: motion with outliers, range balls, ranges and bearings half lost, false loop closures", true,
       10000, scenario_cases},
      {"data", "real range and pose-graph data", true, 1000, data_cases},
      {"window", "a race: 1,000 windows of paper A, one after the other", false, 200, no_cases, race_windows},
      {"papers-a", "paper A's tables: one target, one and two UAVs, outliers and missing measurements", false, 200, no_cases,
       bench_paper_a},
      {"papers-b", "paper B's table: eight followers on a figure of eight, hybrid noise", false, 200, no_cases, bench_paper_b},
      {"papers-c", "paper C's tables: networks localised by ranges and bearings, packets lost", false, 200, no_cases, bench_paper_c},
      {"range", "a race: real range data from odometry", false, 1000, range_cases, race_ranges},
      {"pose-graph", "a race: pose graphs, and how time grows with their size", false, 1000, pose_graph_cases, race_pose_graphs},
      {"network", "a race: random geometric networks of ranges, 100 to 100,000 nodes (--sizes: a million)", false, 10000, no_cases,
       race_networks},
      {"robust", "false loop closures and echoes added to public graphs: losses, GNC, pairwise consistency", false, 1000, no_cases,
       race_robust},
      {"incremental", "the whole history step by step, updated in place: pose graphs, range data, a generated city of 10,000 poses", false,
       1000, no_cases, race_incremental},
      {"online", "a sliding window step by step: time, memory over a million steps, consistency", false, 1000, no_cases, race_online},
  };
  return all;
}

std::vector<Suite> suites_of(const std::vector<std::string>& names) {
  std::vector<Suite> chosen;
  for (const Suite& suite : suites())
    if (names.empty() ? suite.by_default : std::find(names.begin(), names.end(), suite.name) != names.end()) chosen.push_back(suite);
  for (const std::string& name : names) {
    if (std::any_of(suites().begin(), suites().end(), [&](const Suite& suite) { return name == suite.name; })) continue;
    std::string known;
    for (const Suite& suite : suites()) known += std::string(" ") + suite.name;
    fail<BadOption>("there is no suite '", name, "'; there are:", known);
  }
  return chosen;
}

Case data_case(const std::string& file, const std::string& loss, const std::string& start, unsigned seed) {
  const std::string root = data_directory(), path = (fs::path(root) / file).string();
  const ProblemOptions options{Loss::parse(loss), start_named(start), seed};
  Case one{file, loss, start, [path, options] { return load(path, options).instance; }};
  if (root.empty() && fs::path(file).is_relative())
    one.absent = "no data directory: set HOLDFAST_DATA";
  else if (!fs::is_regular_file(path))
    one.absent = "there is no " + path;
  return one;
}

}  // namespace holdfast::bench
