// What `holdfast bench robust` runs: which outliers on which graphs, and by which methods.
#pragma once

#include <holdfast/benchmarks/bench_runner.hpp>
#include <holdfast/benchmarks/suites/false_loops.hpp>
#include <variant>

namespace holdfast::bench {

struct RobustMethod {
  std::string name, backend;
  Loss (*loss)(double c);  ///< of a loop or a range, for a threshold c
  bool pcm = false;        ///< consistent_loops or consistent_ranges first
  bool ranges_only = false;
};

struct RobustSetting {
  const char* graph;
  std::variant<FalseLoops, FalseRanges> attack;

  bool of_ranges() const { return std::holds_alternative<FalseRanges>(attack); }
  std::string kind() const;
  double share() const;
  std::optional<AttackedGraph> make(unsigned seed) const;
  /// Whether the method is one for it.
  bool takes(const RobustMethod& method) const { return of_ranges() || !method.ranges_only; }
};

/// Those that the options choose. Throws BadOption: a name or a share that no one has, with those there are.
std::vector<RobustMethod> robust_methods(const RunnerOptions& options);
std::vector<RobustSetting> robust_settings(const RunnerOptions& options);

}  // namespace holdfast::bench
