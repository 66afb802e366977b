// Cost and gradient only: what a first-order method needs.
#pragma once

#include <holdfast/graph/resolved.hpp>

namespace holdfast {

class GradientEvaluator {
 public:
  explicit GradientEvaluator(const Graph& graph);

  /// Returns the cost; gradient: in Resolved's tangent. The same bits for any number of threads.
  double operator()(const Graph& graph, const Resolved& resolved, const Values& values, std::vector<double>& gradient,
                    ThreadPool* pool = nullptr);

  /// Jᵀ W r̈ along delta (FactorBatch::curvatures), in Resolved's tangent; offsets: by batch, of each variable of each factor.
  void curvature(const Graph& graph, const Resolved& resolved, const Values& values, const Values& moved, double h, const double* delta,
                 const std::vector<std::vector<int>>& offsets, std::vector<double>& out, ThreadPool* pool = nullptr);

 private:
  /// fill(chunk, out) writes the contributions of a chunk's factors; returns the sum of the costs.
  template <class Fill>
  double sum(const Graph& graph, const Resolved& resolved, std::vector<double>& out, ThreadPool* pool, const Fill& fill);

  /// Adds a chunk's contributions to `out`; returns the sum of its costs.
  double scatter(const Graph& graph, const Resolved& resolved, const Chunk& chunk, const double* part, double cost, double* out) const;

  std::vector<Chunk> chunks_;
  std::vector<std::size_t> begin_;  ///< of each chunk's part of contributions_; one thread fills the first part of it alone
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
