// Paper C's experiments: nodes among anchors, all of them moving, a packet of range and bearing on every edge at every step, some lost.
#pragma once

#include <holdfast/benchmarks/scenarios/random.hpp>
#include <vector>

namespace holdfast::bench {

/// How nodes and anchors move, a step a second. The paper has pictures and no numbers: those here are ours.
///   linear         three nodes among three anchors (a triangle with sides of 30 m), step (2, 0.4) m
///   spiral         the same formation, 25 steps a turn, steps growing from 0.8 to 9.9 m (mean 5.1)
///   non_formation  two nodes, two anchors on one side, each at a velocity of its own, 1.7 to 2.4 m/s
///   helix          two nodes outside a triangle of three anchors (sides of 20 m), radius 8 m, 25 steps a turn, climbing 0.5 m a step
/// Nodes start at their places + N(0, 1 m) per axis.
enum class Course { linear, spiral, non_formation, helix };
const char* to_string(Course course);

struct NetworkOptions {
  Course course = Course::linear;
  double lost = 0.5;          ///< share of the packets, at most 0.5; never two in a row, none at step 0
  bool whole_network = true;  ///< all packets of a step are lost together; else each edge loses its own
  int steps = 50;
  double sigma = 0.5;   ///< of a range [m]
  double kappa = 6000;  ///< of a bearing, von Mises–Fisher: 0.74 degrees in the plane
};

template <int S>
struct Network {
  using Position = Vector<S>;
  struct Packet {
    int node;
    int other;  ///< a node above `node`, or an anchor
    bool to_anchor;
    double distance;     ///< [m]
    Position direction;  ///< from the node, unit
    bool received;       ///< else nobody knows the two above
    double previous;     ///< the distance this edge measured one step before (it had arrived if this one is lost)
  };
  struct Step {
    std::vector<Position> nodes;  ///< where they truly are
    std::vector<Position> anchors;
    std::vector<Packet> packets;
  };
  NetworkOptions options;
  std::vector<Step> steps;
  double longest_step;  ///< of a node [m]: the paper's β
};

/// The same for the same seed; the noise of a packet does not depend on whether it is lost. S: 3 for the helix, 2 for the others.
template <int S>
Network<S> make_network(const NetworkOptions& options, unsigned seed);

}  // namespace holdfast::bench
