// Which measurements a graph's losses believe at an answer: computed from graph and values alone, so the same from every back-end.
#pragma once

#include <holdfast/graph/graph.hpp>
#include <unordered_map>

namespace holdfast {

struct MeasurementReport {
  enum class Verdict {
    inlier,
    outlier,     ///< weight < ½
    not_finite,  ///< its residual is not a number at these values
  };
  FactorId id;
  std::string factor;       ///< "Range"
  std::vector<Key> keys;    ///< whose agents it is between: keys[0].agent(), …
  double time;              ///< [s] the latest of its keys' times; NaN: none has one
  std::vector<double> raw;  ///< residual in the units of the measurement; empty where the factor does not say (raw(), sqrt_information)
  std::vector<double> whitened;  ///< residual in sigmas
  double weight;                 ///< ρ'(s) / ρ'(0) in [0, 1], the least of its components: 1 is believed, 0 is ignored
  Verdict verdict;
};

/// Every factor of the graph but LinearPriors, batch by batch. times: of the keys that have one. Throws BadKey, BadType.
std::vector<MeasurementReport> outlier_report(const Graph& graph, const Values& values, const std::unordered_map<Key, double>& times = {});

const char* to_string(MeasurementReport::Verdict verdict);

}  // namespace holdfast
