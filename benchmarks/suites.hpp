// The suites of `holdfast bench`. A new one is a function that lists its cases, and one line in the table of suites.cpp.
#pragma once

#include <holdfast/benchmarks/instance.hpp>
#include <string>
#include <vector>

namespace holdfast::bench {

struct Suite {
  const char* name;
  const char* what;
  bool by_default;     ///< runs when no suite is named
  int max_iterations;  ///< the same for every back-end
  std::vector<Case> (*cases)(unsigned seed);
};

const std::vector<Suite>& suites();
/// Those named, or the default ones. Throws BadOption listing the names.
std::vector<Suite> suites_of(const std::vector<std::string>& names);

std::vector<Case> scenario_cases(unsigned seed);
std::vector<Case> data_cases(unsigned seed);

/// Where the research data is ($HOLDFAST_DATA, or shared/data beside the source tree or the working directory); "" where it is not.
std::string data_directory();

}  // namespace holdfast::bench
