// What `holdfast bench robust` runs: which outliers on which graphs, and by which methods.
#pragma once

#include <holdfast/benchmarks/bench_runner.hpp>
#include <holdfast/benchmarks/suites/false_loops.hpp>
#include <variant>

namespace holdfast::bench {

/// Dynamic covariance scaling (Agarwal, Tipaldi, Spinello, Stachniss & Burgard, ICRA 2013): weight min(1, 2Φ/(Φ + s))², Φ = c². The ρ of
/// that weight: s up to Φ, then Φ (3s − Φ) / (s + Φ).
/// Switchable constraints (Sünderhauf & Protzel, IROS 2012) with each switch at its optimum, min over ω of ω² s + Φ (1 − ω)², are
/// GemanMcClure{c}.
struct DynamicCovarianceScaling {
  double c;
  static const char* name() { return "dcs"; }
  Rho rho(double s) const {
    const double phi = c * c, sum = phi + s;
    if (s <= phi) return {s, 1, 0};
    return {phi * (3 * s - phi) / sum, 4 * phi * phi / (sum * sum), -8 * phi * phi / (sum * sum * sum)};
  }
};

struct RobustMethod {
  std::string name, backend;
  Loss (*loss)(double c);  ///< of a loop or a range, for a threshold c
  bool pcm = false;        ///< of loop closures: pairwise consistency first
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
  bool takes(const RobustMethod& method) const { return of_ranges() ? !method.pcm : !method.ranges_only; }
};

/// Those that the options choose. Throws BadOption: a name or a share that no one has, with those there are.
std::vector<RobustMethod> robust_methods(const RunnerOptions& options);
std::vector<RobustSetting> robust_settings(const RunnerOptions& options);

}  // namespace holdfast::bench
