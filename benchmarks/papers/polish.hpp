// The last digits of an answer, the same from every back-end.
//
// A back-end that compares costs stops where costs have no more digits: √ε before the minimum, and further from it where it converges
// slowly (Ceres leaves out ρ'' and creeps under Huber). Newton's steps on the gradient go the rest of the way: micrometres in paper A's
// windows.
#pragma once

#include <holdfast/solvers/irls/irls.hpp>

namespace holdfast::bench {

class Polish {
 public:
  Polish() {
    newton_.irls_options.reweighting = Reweighting::newton;
    newton_.options.cost_tolerance = 0;
    newton_.options.gradient_tolerance = kFlat;
  }

  /// After a solve of this graph that ended with `summary`.
  void operator()(const Graph& graph, Values& values, const Summary& summary) {
    if (!summary.usable()) return;
    double gradient_norm = summary.gradient_norm;
    // A solve ends with the first step that lowers the cost no more: each is one step here.
    for (int i = 0; i < kMost && gradient_norm > kFlat; ++i) gradient_norm = newton_.solve(graph, values).gradient_norm;
  }

 private:
  static constexpr int kMost = 50;
  static constexpr double kFlat = 1e-9;  ///< largest component of the gradient, whitened
  Irls newton_;
};

}  // namespace holdfast::bench
