// A network's packets as factors, and how an estimate of its nodes is scored.
#pragma once

#include <algorithm>
#include <holdfast/benchmarks/papers/network.hpp>
#include <holdfast/factors/missing_distance.hpp>
#include <holdfast/factors/range_bearing.hpp>
#include <holdfast/graph/graph.hpp>
#include <string>

namespace holdfast::bench {

/// positions[step][node].
template <int S>
using Tracks = std::vector<std::vector<Vector<S>>>;

/// Of a position of the one to the same of the other, over all steps and nodes [m].
template <int S>
double largest_difference(const Tracks<S>& a, const Tracks<S>& b) {
  double largest = 0;
  for (std::size_t k = 0; k < a.size(); ++k)
    for (std::size_t i = 0; i < a[k].size(); ++i) largest = std::max(largest, (a[k][i] - b[k][i]).norm());
  return largest;
}

/// What stands for a packet that was lost: nothing, or paper C's prior that the distance is about what it was one step before.
enum class Missing { nothing, coupled };

/// ρ, one sigma of how far a distance moves in a step: the paper's 0.5 m.
inline constexpr double kDistanceStep = 0.5;

inline Key node_key(int i, int step) { return Agent('A', static_cast<std::uint64_t>(i))(static_cast<std::uint64_t>(step)); }
inline Key anchor_key(int i, int step) { return Agent('L', static_cast<std::uint64_t>(i))(static_cast<std::uint64_t>(step)); }

/// The anchors of one step, fixed, and its packets between them and nodes of type V.
template <class V, int S>
void add_packets(const Network<S>& network, int step, Missing missing, Graph& graph, Values& values) {
  using Anchor = Kinematic<double, S, 1>;
  const auto& now = network.steps[step];
  for (std::size_t a = 0; a < now.anchors.size(); ++a) {
    values.insert(anchor_key(static_cast<int>(a), step), Anchor(now.anchors[a]));
    graph.fix(anchor_key(static_cast<int>(a), step));
  }
  const double sigma = network.options.sigma, kappa = network.options.kappa;
  for (const auto& packet : now.packets) {
    const Key from = node_key(packet.node, step);
    const Key to = packet.to_anchor ? anchor_key(packet.other, step) : node_key(packet.other, step);
    if (packet.received && packet.to_anchor)
      graph.add(RangeBearing<V, Anchor>{packet.distance, sigma, packet.direction, kappa}, {from, to});
    else if (packet.received)
      graph.add(RangeBearing<V, V>{packet.distance, sigma, packet.direction, kappa}, {from, to});
    else if (missing == Missing::coupled && packet.to_anchor)
      graph.add(MissingDistance<V, Anchor>{packet.previous, sigma, kDistanceStep}, {from, to});
    else if (missing == Missing::coupled)
      graph.add(MissingDistance<V, V>{packet.previous, sigma, kDistanceStep}, {from, to});
  }
}

/// Mean over steps and nodes of the distance to the truth [m], which is what paper C scores by; and the root mean square.
struct NetworkError {
  double mean;
  double rms;
};
template <int S>
NetworkError error_of(const Network<S>& network, const Tracks<S>& tracks) {
  double sum = 0, squares = 0;
  int count = 0;
  for (std::size_t k = 0; k < tracks.size(); ++k)
    for (std::size_t i = 0; i < tracks[k].size(); ++i, ++count) {
      const double error = (tracks[k][i] - network.steps[k].nodes[i]).norm();
      sum += error;
      squares += error * error;
    }
  return {sum / count, std::sqrt(squares / count)};
}

}  // namespace holdfast::bench
