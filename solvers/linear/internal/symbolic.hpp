// The symbolic phase of the sparse Cholesky factorisation: the elimination tree of supernodes.
//
// A supernode is a set of block columns eliminated together in one dense front: k own scalar columns, n ≥ k rows. Supernodes
// are merged (zeros and all) wherever a cost model of the machine says that one larger front is faster than two.
#pragma once

#include <holdfast/solvers/linear/internal/ordering.hpp>

namespace holdfast {

struct Symbolic {
  struct Supernode {
    int first, last;        ///< block columns [first, last) in elimination order
    int parent = -1;        ///< supernode; always a later one
    int k = 0, n = 0;       ///< scalar columns, and rows of the front
    std::vector<int> rows;  ///< block rows below the own columns, ascending
  };
  std::vector<int> order;  ///< nodes, first eliminated first: a postorder of the tree
  std::vector<Supernode> supernodes;
  double flops = 0;  ///< multiply–add pairs of one factorisation
};

/// Σ_{j<k} (n − j)²: the multiply–add pairs (twice over) of eliminating k of n columns.
double front_flops(int k, int n);

/// The tree for a given order of the nodes (the order itself is refined to a postorder of equal fill).
Symbolic analyze(const BlockGraph& graph, const std::vector<int>& order);

/// Minimum degree; where that leaves much work, nested dissection as well, and the cheaper of the two.
Symbolic analyze(const BlockGraph& graph);

}  // namespace holdfast
