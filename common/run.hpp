// One back-end on one problem, and the line of JSON that is kept of it.
#pragma once

#include <holdfast/common/instance.hpp>
#include <holdfast/common/metrics.hpp>
#include <holdfast/solvers/backend.hpp>
#include <nlohmann/json.hpp>

namespace holdfast::common {

using Json = nlohmann::ordered_json;

/// What a run was asked to do.
struct Task {
  std::string file, loss, start;
  std::string backend;
  unsigned seed = 0;
  Options options;
};

struct Run {
  Task task;
  Summary summary;
  std::vector<double> seconds;  ///< of each repetition
  std::optional<PositionError> error;
  RejectedCount rejected;
  std::size_t variables = 0;
  std::size_t factors = 0;
};

/// Solves from instance.start; `answer` is that start where the solve fails. A problem that cannot be posed is a failed run, not an
/// exception.
Run run_task(const Task& task, const Instance& instance, Values& answer);

/// The middle one, or the mean of the two in the middle.
double median(std::vector<double> numbers);

/// The least of them that 95 of 100 do not exceed.
double percentile_95(std::vector<double> numbers);

/// One line of results (docs/results_format.md). Unknown and non-finite numbers are null; `seconds` is the median of the repetitions;
/// `trace` is there where Options::trace was set.
Json to_json(const Run& run);

/// One line of a .jsonl file, end of line included; bytes of a file name that are no UTF-8 are replaced.
std::string to_line(const Json& json);

}  // namespace holdfast::common
