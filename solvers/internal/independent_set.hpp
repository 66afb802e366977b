// The largest set of nodes of which no two are in conflict: the maximum clique of the consistent pairs, seen from the other side. The
// conflicts are few, so their graph falls apart: nodes without a conflict are in, a node with one conflict is as good as its partner, and
// each connected part is searched for itself, by branch and bound over bit sets with greedy colours as the bound (San Segundo et al.,
// "An exact bit-parallel algorithm for the maximum clique problem", Computers & OR 2011), from a greedy set: the node with the fewest
// conflicts first, then swaps of one for two. Internal.
#pragma once

#include <vector>

namespace holdfast::detail {

struct IndependentSet {
  std::vector<int> members;  ///< ascending
  bool is_exact = true;      ///< false: the time was up in some part, whose best set so far is taken
};

/// conflicts[i]: the nodes in conflict with i; symmetric, without i, without repetition. time_limit [s]: of the exact search; 0: greedy.
/// The same answer on every machine where the time suffices.
IndependentSet largest_independent_set(const std::vector<std::vector<int>>& conflicts, double time_limit);

}  // namespace holdfast::detail
