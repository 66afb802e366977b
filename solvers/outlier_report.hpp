// Which measurements a graph's losses believe at an answer: computed from graph and values alone, so the same from every back-end.
#pragma once

#include <holdfast/graph/graph.hpp>
#include <unordered_map>

namespace holdfast {

/// How far a loss believes a whitened residual r of m components: ρ'(s) / ρ'(0) in [0, 1]; of a loss per component the least of its
/// components; 1 on the harmless side of a one-sided loss. 1 is believed, 0 is ignored.
double relative_weight(const Loss& loss, const double* r, int m);

/// The one rule for "rejected", here and wherever measurements are counted: a relative weight below ½. Squared rejects nothing, Huber{a}
/// what is beyond 2a sigmas, Cauchy{c} beyond c, TruncatedSquares{c} beyond c, StudentT{ν} where ‖r‖² > ν,
/// Absolute, which has a corner and no inliers, what is beyond √3 widths.
inline bool is_rejected(double relative_weight) { return relative_weight < 0.5; }

struct MeasurementReport {
  enum class Verdict {
    inlier,
    outlier,     ///< is_rejected(weight)
    not_finite,  ///< its residual is not a number at these values
  };
  FactorId id;
  std::string factor;       ///< "Range"
  std::vector<Key> keys;    ///< whose agents it is between: keys[0].agent(), …
  double time;              ///< [s] the latest of its keys' times; NaN: none has one
  std::vector<double> raw;  ///< residual in the units of the measurement; empty where the factor does not say (raw(), sqrt_information)
  std::vector<double> whitened;  ///< residual in sigmas
  double weight;                 ///< relative_weight
  Verdict verdict;
};

/// Every factor of the graph but LinearPriors, batch by batch. times: of the keys that have one. Throws BadKey, BadType.
std::vector<MeasurementReport> outlier_report(const Graph& graph, const Values& values, const std::unordered_map<Key, double>& times = {});

const char* to_string(MeasurementReport::Verdict verdict);

}  // namespace holdfast
