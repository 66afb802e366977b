// What the factors of a graph leave free at some values: directions of the tangent that change no residual.
#pragma once

#include <holdfast/graph/resolved.hpp>
#include <string>
#include <vector>

namespace holdfast {

/// A set of variables that factors tie together, directly or not.
struct Component {
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
std::vector<Component> observability(const Graph& graph, const Resolved& resolved, const Values& values);

}  // namespace holdfast
