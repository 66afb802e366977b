// A problem as every estimator of a comparison gets it: the same graph, the same start, and what is known of the answer.
#pragma once

#include <functional>
#include <holdfast/adapters/files/problem.hpp>
#include <holdfast/graph/check.hpp>
#include <string>
#include <unordered_map>

namespace holdfast::common {

struct Instance {
  Graph graph;
  Values start;
  Values truth;  ///< what is scored; empty: unknown
};

/// An instance under its name; made when it is its turn.
struct Case {
  std::string name;  ///< a file or a scenario
  std::string loss;  ///< of its measurements
  std::string start;
  std::function<Instance()> make;
  std::string absent = {};  ///< why it cannot be made here ("" if it can)
};

/// A file as a problem.
struct FileProblem {
  Instance instance;  ///< truth: the poses of a PyFG file, whose vertices are true; of mrpt-common's data what its files of truth hold
  std::unordered_map<Key, double> times;
  std::string unknown;                 ///< the report on tags nobody knows, "" if there are none
  std::string start = {};              ///< how a convex start was found, "" for the others
  std::string used = {};               ///< use_report
  std::vector<Finding> findings = {};  ///< on the file's lines (adapters/files/report.hpp), not on the problem
  Dataset dataset = {};
};
/// PyFG, g2o, TORO by content, MRPT's .rawlog by name (beacons found from their ranges). Throws an Error that names the file.
FileProblem load(const std::string& path, const ProblemOptions& options, const ReadOptions& reading = {});
/// Its dataset alone.
Dataset read_any(const std::string& path, const ReadOptions& reading = {});

}  // namespace holdfast::common
