// The free variables of a problem over a vector space as one array: their tangent from a base point. Internal.
#pragma once

#include <holdfast/graph/resolved.hpp>

namespace holdfast::detail {

class FlatValues {
 public:
  /// True where every variable that a factor touches is of a vector space: x ⊕ δ adds coordinates.
  static bool serves(const Graph& graph, const Values& values);

  FlatValues(const Resolved& resolved, const Values& base);

  /// to = base ⊕ u. `to` has the structure of the base.
  void write(const std::vector<double>& u, Values& to) const;

 private:
  struct Run {                      // free variables side by side, in the pool and in the tangent
    int pool, begin, offset, size;  // in doubles
  };
  std::vector<Run> runs_;
  std::vector<double> base_;
};

}  // namespace holdfast::detail
