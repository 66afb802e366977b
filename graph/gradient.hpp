// Cost and gradient only: what a first-order method needs.
#pragma once

#include <holdfast/graph/resolved.hpp>

namespace holdfast {

class GradientEvaluator {
 public:
  explicit GradientEvaluator(const Graph& graph);

  /// Returns the cost; gradient: in Resolved's tangent. The same bits for any number of threads.
  double operator()(const Graph& graph, const Resolved& resolved, const Values& values, std::vector<double>& gradient, ThreadPool* pool = nullptr);

 private:
  std::vector<Chunk> chunks_;
  std::vector<std::size_t> begin_;  ///< of each chunk's part of contributions_
  std::vector<double> contributions_;
};

/// The gradient of Graph::cost in the tangent of the free variables, with who is where: for users and tests.
struct Gradient {
  std::vector<Key> keys;
  std::vector<int> offsets;  ///< of each key's tangent in value
  std::vector<double> value;
};
Gradient gradient(const Graph& graph, const Values& values);

}  // namespace holdfast
