// A random geometric network of which each process makes its own part: the same network for any number of processes.
#pragma once

#include <cstdint>
#include <holdfast/graph/graph.hpp>

namespace holdfast::program {

struct SpreadNetwork {
  Graph graph;    ///< the factors that this process adds
  Values values;  ///< its own nodes, at the start
};

/// One node a square metre; a square of cells as wide as the radio's range r, which makes eight neighbours on average. Each cell draws its
/// own nodes from its own seed, a tenth of them anchors, fixed where they are, and each pair nearer than r has a RangeBall with 2 % of
/// noise from a seed of the pair. Process `rank` of `size` has a rectangle of cells, and looks one cell beyond. Start: near_anchors: the
/// mean of the anchors in the cell of the node and the eight about it (in its middle where there is none); else all at the middle of the
/// square.
SpreadNetwork spread_network(std::int64_t nodes, unsigned seed, bool near_anchors, int rank, int size);

}  // namespace holdfast::program
