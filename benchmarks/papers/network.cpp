#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <holdfast/benchmarks/papers/network.hpp>
#include <utility>

namespace holdfast::bench {
namespace {

constexpr double kTurn = 2 * kPi / 25;  // of a spiral or helix, a step

/// Loses a share of what is sent, never two in a row, and not the first.
class Channel {
 public:
  /// After a loss the next one always arrives: losing with chance q otherwise loses q / (1 + q) of all.
  Channel(double lost, Random& random) : chance_(lost / (1 - lost)), received_(!random.chance(lost)) {}
  /// The first arrives even where it counts as lost: so that channels that lose every other one do not all lose the same.
  bool receives(Random& random) {
    if (std::exchange(first_, false)) return true;
    received_ = !(received_ && random.chance(chance_));
    return received_;
  }

 private:
  double chance_;
  bool received_, first_ = true;
};

/// One vehicle: where it is at step 0, and its velocity [m/step] where it does not follow the formation.
template <int S>
struct Vehicle {
  Vector<S> place, velocity;
};

template <int S>
struct Fleet {
  std::vector<Vehicle<S>> nodes, anchors;
};

Vector<2> corner(double side, int i) {
  return side / std::sqrt(3) * Vector<2>(std::cos(kPi / 2 + 2 * kPi * i / 3), std::sin(kPi / 2 + 2 * kPi * i / 3));
}

Fleet<2> fleet_of(Course course, const Vector<2>& still) {
  using V = Vector<2>;
  Fleet<2> fleet;
  if (course == Course::non_formation) {
    fleet.nodes = {{V(-4, 3), V(2.3, 0.3)}, {V(0, -5), V(1.7, 0.1)}};
    fleet.anchors = {{V(-12, 10), V(2, 0.6)}, {V(-14, -8), V(2, -0.2)}};
    return fleet;
  }
  for (int i = 0; i < 3; ++i) {
    fleet.nodes.push_back({corner(10, i), still});
    fleet.anchors.push_back({corner(30, i), still});
  }
  return fleet;
}

Fleet<3> fleet_of(Course, const Vector<3>& still) {
  Fleet<3> fleet;
  fleet.nodes = {{Vector<3>(20, 6, 3), still}, {Vector<3>(22, -5, -2), still}};
  for (int i = 0; i < 3; ++i) {
    const Vector<2> p = corner(20, i);
    fleet.anchors.push_back({Vector<3>(p[0], p[1], 0), still});
  }
  return fleet;
}

Vector<2> moved(Course course, int step, const Vector<2>& velocity) {
  constexpr double kGrowth = 0.8;  // [m/step]
  if (course == Course::linear) return step * Vector<2>(2, 0.4);
  if (course == Course::spiral) return kGrowth * step * Vector<2>(std::cos(kTurn * step), std::sin(kTurn * step));
  return step * velocity;
}

Vector<3> moved(Course, int step, const Vector<3>&) {
  constexpr double kRadius = 8, kClimb = 0.5;  // [m], [m/step]
  return {kRadius * (std::cos(kTurn * step) - 1), kRadius * std::sin(kTurn * step), kClimb * step};
}

/// e turned by a von Mises error, which is normal at such concentrations.
Vector<2> disturbed(const Vector<2>& e, double kappa, Random& random) {
  const double angle = std::atan2(e[1], e[0]) + random.normal() / std::sqrt(kappa);
  return {std::cos(angle), std::sin(angle)};
}

/// A von Mises–Fisher direction about e: its cosine has density ∝ exp(κ c).
Vector<3> disturbed(const Vector<3>& e, double kappa, Random& random) {
  const double u = random.uniform(), around = random.uniform(0, 2 * kPi);
  const double c = 1 + std::log(u + (1 - u) * std::exp(-2 * kappa)) / kappa, s = std::sqrt(std::max(0.0, 1 - c * c));
  const Vector<3> across = e.unitOrthogonal();
  return (c * e + s * (std::cos(around) * across + std::sin(around) * e.cross(across))).normalized();
}

template <int S>
double longest_step(const std::vector<typename Network<S>::Step>& steps) {
  double longest = 0;
  for (std::size_t k = 1; k < steps.size(); ++k)
    for (std::size_t i = 0; i < steps[k].nodes.size(); ++i) longest = std::max(longest, (steps[k].nodes[i] - steps[k - 1].nodes[i]).norm());
  return longest;
}

}  // namespace

const char* to_string(Course course) {
  static constexpr std::array<const char*, 4> kNames{"linear", "spiral", "non-formation", "helix"};
  return kNames[static_cast<std::size_t>(course)];
}

template <int S>
Network<S> make_network(const NetworkOptions& options, unsigned seed) {
  constexpr double kLeastDistance = 0.1;  // [m]
  Random noise(seed), losses(~static_cast<std::uint64_t>(seed));
  Fleet<S> fleet = fleet_of(options.course, Vector<S>(Vector<S>::Zero()));
  for (Vehicle<S>& node : fleet.nodes) node.place += noise.normals<S>(1);
  const int nodes = static_cast<int>(fleet.nodes.size()), anchors = static_cast<int>(fleet.anchors.size());
  std::vector<Channel> channels;
  for (int i = 0; i < (options.whole_network ? 1 : nodes * (nodes + anchors)); ++i) channels.emplace_back(options.lost, losses);
  Network<S> network{options, {}, 0};
  for (int k = 0; k < options.steps; ++k) {
    typename Network<S>::Step step;
    for (const auto& node : fleet.nodes) step.nodes.push_back(node.place + moved(options.course, k, node.velocity));
    for (const auto& anchor : fleet.anchors) step.anchors.push_back(anchor.place + moved(options.course, k, anchor.velocity));
    const bool all = options.whole_network && channels[0].receives(losses);
    for (int i = 0; i < nodes; ++i)
      for (int j = i + 1; j < nodes + anchors; ++j) {
        const bool to_anchor = j >= nodes;
        const int other = to_anchor ? j - nodes : j;
        const Vector<S> x = (to_anchor ? step.anchors : step.nodes)[other] - step.nodes[i];
        const double distance = std::max(kLeastDistance, x.norm() + options.sigma * noise.normal());
        const Vector<S> direction = disturbed(Vector<S>(x / x.norm()), options.kappa, noise);
        const bool received = options.whole_network ? all : channels[i * (anchors + nodes) + j].receives(losses);
        const double previous = k == 0 ? distance : network.steps.back().packets[step.packets.size()].distance;
        step.packets.push_back({i, other, to_anchor, distance, direction, received, previous});
      }
    network.steps.push_back(std::move(step));
  }
  network.longest_step = longest_step<S>(network.steps);
  return network;
}

template Network<2> make_network<2>(const NetworkOptions&, unsigned);
template Network<3> make_network<3>(const NetworkOptions&, unsigned);

}  // namespace holdfast::bench
