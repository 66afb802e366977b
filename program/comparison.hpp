// Two outputs of `holdfast bench`, run by run: what got faster or slower, what ends lower or higher.
//
// A run of A is paired with the run of B of the same problem and settings. Of the pairs of one back-end (or method) that both ended, the
// geometric mean of seconds(B) / seconds(A), and its 95 % interval by the percentile bootstrap over the pairs: problems are drawn anew,
// with replacement, so the interval says how far the mean depends on which problems there were and on the noise in each.
#pragma once

#include <holdfast/common/run.hpp>
#include <string>
#include <vector>

namespace holdfast::program {

/// The lines of a .jsonl file, or of all of them in a directory; of each file those of its newest commit. BadFile where there are none, or
/// naming the line that is no JSON object.
std::vector<common::Json> result_lines(const std::string& path);

enum class Speed { faster, slower, open, too_few };
const char* to_string(Speed speed);

struct GroupChange {
  std::string name;  ///< a back-end or a method
  int pairs = 0;
  int timed = 0;                         ///< pairs that both ended, and have seconds
  double ratio = 0, low = 0, high = 0;   ///< seconds of B over those of A; NaN where none is timed
  Speed speed = Speed::too_few;          ///< faster, slower: the whole interval is on one side of 1; too_few: fewer than 5 pairs
  int lower = 0, equal = 0, higher = 0;  ///< costs of B, relative to A's, by kSameCost
  int newly_failed = 0, newly_solved = 0;
};

struct Comparison {
  std::vector<GroupChange> groups;
  std::vector<std::string> worse;      ///< runs of B that failed or ended higher, by name
  std::size_t only_a = 0, only_b = 0;  ///< runs without a partner
  std::size_t other = 0;               ///< lines that are no runs
  bool is_worse() const;               ///< a group is slower, or a run is worse
};
Comparison compare(const std::vector<common::Json>& a, const std::vector<common::Json>& b);

}  // namespace holdfast::program
