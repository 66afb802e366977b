// Paper C's MAP estimators, convex, on any back-end: what its section 2.3 may be read to mean.
#pragma once

#include <holdfast/benchmarks/papers/network_graph.hpp>

namespace holdfast::bench {

struct MissingMap {
  /// fixed: x(t − 1) in the prior of x(t) is the estimate of one step before, as (14) has it: each step is solved alone, in turn.
  /// free: all steps together, a random walk.
  enum class Previous { fixed, free };
  Previous previous = Previous::fixed;
  /// nothing: (8)(9) as printed, where Ω and y of a lost packet enter no measured term, so that Ω = d(t − 1) and says nothing of x.
  Missing missing = Missing::nothing;
};

/// Minimises Σ ½‖x_i(t) − x_i(t − 1)‖²/β² + the relaxed packets (5)–(7). β: the longest step of a node, as the paper chose it. Step 0 has
/// no prior. Throws BadProblem where the back-end fails.
template <int S>
Tracks<S> missing_map(const Network<S>& network, const MissingMap& form, const std::string& backend);

/// All steps together, x(t − 1) free: the convex problem, and its start with every node at the middle of its step's anchors.
struct MapProblem {
  Graph graph;
  Values start;
};
template <int S>
MapProblem map_problem(const Network<S>& network, Missing missing);

/// Root mean square of d(t − 1) − d(t) over the lost packets [m]: what the paper's Ω is worth.
template <int S>
double omega_error(const Network<S>& network);

}  // namespace holdfast::bench
