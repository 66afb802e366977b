// Elimination orders of the block graph (one node a variable) with little fill-in.
#pragma once

#include <holdfast/graph/resolved.hpp>

namespace holdfast {

/// Which free variables share a factor: neighbours of i are neighbours[begin[i]] … neighbours[begin[i+1]−1], ascending, without i.
struct BlockGraph {
  std::vector<int> dims;
  std::vector<int> begin{0};
  std::vector<int> neighbours;

  int size() const { return static_cast<int>(dims.size()); }
};

/// Node i is the i-th free variable of `resolved`; its number there is variable[i].
BlockGraph block_graph(const Graph& graph, const Resolved& resolved, std::vector<int>& variable);

/// Approximate minimum degree: the nodes, first eliminated first.
std::vector<int> minimum_degree_order(const BlockGraph& graph);

/// Nested dissection by METIS; empty where holdfast was built without it or no two nodes are neighbours.
std::vector<int> nested_dissection_order(const BlockGraph& graph);

}  // namespace holdfast
