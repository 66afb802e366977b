#include <holdfast/benchmarks/papers/network_graph.hpp>
#include <holdfast/benchmarks/scenarios/scenario.hpp>
#include <holdfast/factors/white_acceleration.hpp>

namespace holdfast::bench {

Instance formation(double lost, unsigned seed) {
  constexpr double kDensity = 0.1;  // of the nodes' acceleration [m²/s³]
  NetworkOptions options;
  options.lost = lost;
  options.whole_network = false;
  const Network<2> network = make_network<2>(options, seed);
  const auto motion = WhiteAcceleration<Motion2>::continuous(1, kDensity);
  Instance instance;
  for (int k = 0; k < options.steps; ++k) {
    const auto& now = network.steps[k];
    const auto& other = network.steps[k == 0 ? 1 : k - 1];
    const Vector<2> centre = (now.anchors[0] + now.anchors[1] + now.anchors[2]) / 3;
    for (int i = 0; i < static_cast<int>(now.nodes.size()); ++i) {
      const Vector<2> velocity = k == 0 ? other.nodes[i] - now.nodes[i] : now.nodes[i] - other.nodes[i];
      instance.truth.insert(node_key(i, k), Motion2(now.nodes[i][0], velocity[0], now.nodes[i][1], velocity[1]));
      instance.start.insert(node_key(i, k), Motion2(centre[0], 0.0, centre[1], 0.0));
      if (k > 0) instance.graph.add(motion, {node_key(i, k - 1), node_key(i, k)});
    }
    add_packets<Motion2>(network, k, Missing::nothing, instance.graph, instance.start);
  }
  instance.graph = instance.graph.relaxed();
  return instance;
}

}  // namespace holdfast::bench
