// From no initial guess: the convex relaxation first, then the exact problem.
//
//   auto backend = make_backend("irls");
//   const ConvexStart found = convex_start(graph, values, *backend);   // values: which variables there are; answer out
//
//   1. every position goes to the centroid of what is known: fixed variables, and those that factors of their own (priors) place; to the
//      origin where nothing is. Rotations and derivatives stay as they are given;
//   2. Graph::relaxed() is solved: every factor that has a convex counterpart gives way to it, every loss that is not convex to Huber;
//   3. the back-end solves the graph itself from there.
//
// Where all that is left is convex (points and motion states), the answer of 2 does not depend on the values given, and no local
// minimum can hold it. Poses keep their rotations in 1 and turn in 2 and 3: give them a start of their own (chordal_start).
// RangeBearing keeps its length in 2; ranges alone are only bounded from above, so that what is not among anchors may shrink.
#pragma once

#include <holdfast/solvers/backend.hpp>

namespace holdfast {

/// How the start was found.
struct RelaxedStart {
  double cost_centroid = 0;  ///< of the graph, every position at the centroid
  Summary relaxed;           ///< of the relaxed graph, from there
  bool is_convex = false;    ///< every factor and loss of it is
  double cost = 0;           ///< of the graph at the answer of the relaxed one
  std::string str() const;
};

/// 1 and 2. Options: of the relaxed solve, by irls, and where that is convex and has not converged in 200 iterations by nesterov from
/// there. Throws what Backend::solve throws. Values are unchanged where it fails (relaxed.usable() is false).
RelaxedStart relaxed_start(const Graph& graph, Values& values, const Options& options = {});

struct ConvexStart {
  RelaxedStart start;
  Summary refined;
};

/// 1 to 3. Values are unchanged where it fails (refined.usable() is false).
ConvexStart convex_start(const Graph& graph, Values& values, Backend& backend);

}  // namespace holdfast
