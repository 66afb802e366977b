// What every back-end can be asked for. Each option means the same in all of them; what only one has is in a struct of its own
// (IrlsOptions, GncOptions).
#pragma once

#include <functional>
#include <limits>

namespace holdfast {

/// One iteration, as it is traced and handed to the progress callback.
struct Iteration {
  int number;            ///< 0: the start
  double cost;           ///< Σ w ½ρ of the best values so far
  double gradient_norm;  ///< largest component of the gradient in the tangent
  double seconds;        ///< since the solve began
};

struct Options {
  int max_iterations = 0;             ///< >= 0; 0: the back-end's own: 1000, and 10,000 for first-order ones
  double cost_tolerance = 1e-6;       ///< >= 0: an accepted step that lowers the cost by less than this part of it ends the solve
  double gradient_tolerance = 1e-10;  ///< >= 0: the largest component of the gradient (tangent, whitened)
  int threads = 1;                    ///< 1 … 1024; in-house back-ends give the same bits for any number
  double time_limit = std::numeric_limits<double>::infinity();  ///< > 0 [s]; the best values so far are the answer
  bool second_order = false;  ///< where the end is a saddle, leave it and solve on (second_order.hpp); the Summary says what was found
  bool findings = false;      ///< check(graph, answer) into the Summary (graph/check.hpp)
  bool trace = false;         ///< keep every iteration in the Summary
  std::function<bool(const Iteration&)> progress;  ///< called after each iteration; false stops the solve

  /// Throws BadOption with field, value and rule.
  void validate() const;
};

}  // namespace holdfast
