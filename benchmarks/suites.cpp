#include <algorithm>
#include <holdfast/benchmarks/suites.hpp>

namespace holdfast::bench {

const std::vector<Suite>& suites() {
  static const std::vector<Suite> all{
      {"scenarios", "made from the seed: motion with outliers, range balls, ranges and bearings half lost, false loop closures", true,
       10000, scenario_cases},
      {"data", "real range and pose-graph data", true, 1000, data_cases},
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

}  // namespace holdfast::bench
