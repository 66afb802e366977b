// What the factors of a graph leave free at some values: directions of the tangent that change no residual.
#pragma once

#include <holdfast/graph/resolved.hpp>
#include <string>
#include <vector>

namespace holdfast {

namespace detail {

/// The one rule for what cannot be observed, here and in Marginals: a direction z is free where zᵀ H z is at most 1e-15 of
/// zᵀ diag(H) z. What is left of zᵀ H z for a null vector in double precision is a few 1e-16 of it, so that a difference cannot be told.
inline bool is_unobservable(double zHz, double z_diagonal_z) { return !(zHz > 1e-15 * z_diagonal_z); }

/// A pivot of a factorisation is zᵀ H z of one z with z_j = 1: where it exceeds this part of H_jj, z is not looked at.
inline constexpr double kSuspectPivot = 1e-8;

}  // namespace detail

/// A set of variables that factors tie together, directly or not.
struct GraphComponent {
  std::vector<int> variables;      ///< numbers in Resolved::variables; free ones only
  std::vector<std::string> gauge;  ///< rigid motions of the whole component that cost nothing: "translation x", "rotation z", …
  struct Direction {
    Key key;         ///< the variable that moves most
    int component;   ///< the entry of its tangent that moves most
    int others;      ///< how many more variables move with it
    bool only_here;  ///< a factor on this variable has a zero Jacobian at these values (a one-sided factor at rest)
  };
  std::vector<Direction> directions;  ///< further free directions
  int more_directions = 0;            ///< not listed any more
};

/// Components of the graph on its free variables, each with its free directions; losses are left out (every term counts as squared).
std::vector<GraphComponent> observability(const Graph& graph, const Resolved& resolved, const Values& values);

}  // namespace holdfast
