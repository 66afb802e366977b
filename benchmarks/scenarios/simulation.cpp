#include <algorithm>
#include <holdfast/adapters/files/to_dataset.hpp>
#include <holdfast/adapters/files/vertex_value.hpp>
#include <holdfast/benchmarks/scenarios/random.hpp>
#include <holdfast/benchmarks/scenarios/simulation.hpp>
#include <holdfast/benchmarks/suites/suites.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/factors/range_ball.hpp>

namespace holdfast::bench {
namespace {

using Balls = RangeBall<Point2, Point2>;

/// Files hold what was measured: a ball's distance is a range.
Graph with_ranges(const Graph& graph) {
  Graph measured;
  for (std::size_t b = 0; b < graph.batches().size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    for (int i = 0; i < batch.size(); ++i) {
      if (batch.factor_type() == typeid(Balls)) {
        const Balls& ball = static_cast<const Batch<Balls>&>(batch).factors()[i];
        measured.add(Range<Point2, Point2>{ball.distance, ball.sigma}, {batch.keys(i)[0], batch.keys(i)[1]});
      } else {
        measured.add_from(graph, graph.id_of(static_cast<int>(b), i));
      }
    }
  }
  for (const Key key : graph.fixed()) measured.fix(key);
  return measured;
}

Instance instance_of(const SimulationOptions& options) {
  const std::string& name = options.scenario;
  if (name == "fleet") return fleet(options.agents, options.steps, options.seed);
  if (name == "swarm") return swarm(options.agents, options.seed);
  if (name == "network") return network(options.agents, options.seed);
  if (name == "ring") return ring(options.steps, Loss(), options.seed, 0);  // false closures are drawn as everybody's are
  return grid_walk(name == "walk2d" ? 2 : 3, options.steps, options.seed);
}

/// The options with the scenario's own numbers where none are given; BadOption where one makes no sense.
SimulationOptions checked(SimulationOptions options) {
  const SimulatedScenario* scenario = nullptr;
  std::string names;
  for (const SimulatedScenario& one : simulated_scenarios()) {
    if (options.scenario == one.name) scenario = &one;
    names += std::string(names.empty() ? "" : ", ") + one.name;
  }
  if (scenario == nullptr) fail<BadOption>("there is no scenario '", options.scenario, "'; there are ", names);
  const auto choose = [&](int& number, int own, const char* what, int least) {
    if (number != 0 && own == 0) fail<BadOption>("the scenario ", scenario->name, " has no number of ", what, " to choose");
    if (number == 0) number = own;
    if (own != 0 && number < least) fail<BadOption>(what, " of ", scenario->name, ": ", number, "; give ", least, " or more");
  };
  choose(options.agents, scenario->agents, "agents", options.scenario == "fleet" ? 1 : 4);
  choose(options.steps, scenario->steps, "steps", options.scenario == "ring" ? 10 : 2);
  if (!(options.noise > 0 && std::isfinite(options.noise))) fail<BadOption>("noise ", options.noise, ": it is a factor above 0");
  for (const double share : {options.outliers, options.lost})
    if (!(share >= 0 && share <= 1)) fail<BadOption>("a share of measurements is from 0 to 1, not ", share);
  return options;
}

/// Odometry is between consecutive steps of one agent.
template <class V>
bool is_odometry(const RelativePoseEdge<V>& edge) {
  return edge.first.agent() == edge.second.agent() && edge.first.step() + 1 == edge.second.step();
}

/// Turns the measurements of a scenario into those that were asked for.
class Disturber {
 public:
  Disturber(const SimulationOptions& options, Simulation& simulation)
      : options_(options), simulation_(simulation), random_(~std::uint64_t{options.seed}) {}

  void disturb() {
    std::vector<Edge>& edges = simulation_.dataset.edges;
    std::vector<Edge> kept;
    for (Edge& edge : edges)
      if (std::visit([this](auto& measurement) { return keep(measurement); }, edge.measurement)) kept.push_back(edge);
    edges = std::move(kept);
  }

 private:
  bool keep(RangeEdge& range) {
    constexpr double kShortest = 5, kLongest = 50;  // beyond the truth [m]
    const double truth = (position(range.second) - position(range.first)).norm();
    range.distance = std::max(0.0, truth + options_.noise * (range.distance - truth));
    range.variance *= options_.noise * options_.noise;
    if (is_lost()) return false;
    if (is_false()) range.distance = truth + random_.uniform(kShortest, kLongest);
    return true;
  }
  bool keep(RelativePoseEdge<Pose2>& edge) { return keep_pose(edge); }
  bool keep(RelativePoseEdge<Pose3>& edge) { return keep_pose(edge); }
  template <class V>
  bool keep_pose(RelativePoseEdge<V>& edge) {
    const V truth = value<V>(edge.first).inverse() * value<V>(edge.second);
    set_noise(edge, truth);
    if (is_odometry(edge)) return true;
    if (is_lost()) return false;
    if (is_false()) edge.measured = V().retract(truth.local(edge.measured));
    return true;
  }
  template <class V>
  bool keep(PriorEdge<V>& edge) {
    set_noise(edge, value<V>(edge.key));
    return true;
  }
  template <class Other>
  bool keep(Other&) {  // scenarios have no others
    return true;
  }

  template <class E, class V>
  void set_noise(E& edge, const V& truth) {
    edge.measured = truth.retract(options_.noise * truth.local(edge.measured));
    edge.noise.written /= options_.noise * options_.noise;
  }
  bool is_lost() {
    const bool lost = random_.chance(options_.lost);
    simulation_.lost_measurements += lost ? 1 : 0;
    return lost;
  }
  bool is_false() {
    const bool is_false = random_.chance(options_.outliers);
    simulation_.false_measurements += is_false ? 1 : 0;
    return is_false;
  }
  template <class V>
  V value(Key key) const {
    return simulation_.truth.at<V>(key);
  }
  Vector<3> position(Key key) const {
    Vector<3> p = Vector<3>::Zero();
    std::visit(
        [&p](const auto& one) {
          using V = std::decay_t<decltype(one)>;
          if constexpr (V::dim > V::space_dim)
            p.head<V::space_dim>() = one.p;
          else
            p.head<V::space_dim>() = one.value;
        },
        *vertex_value(simulation_.truth, key));
    return p;
  }

  const SimulationOptions& options_;
  Simulation& simulation_;
  Random random_;  // not the scenario's draws
};

}  // namespace

const std::vector<SimulatedScenario>& simulated_scenarios() {
  static const std::vector<SimulatedScenario> scenarios{
      {"fleet", "robots with odometry, ranges between them and to four beacons", 3, 100},
      {"swarm", "points that know ranges to their neighbours, a tenth of them where they are", 100, 0},
      {"network", "the same in a network of radios, a tenth of the nodes fixed", 100, 0},
      {"ring", "two laps on a circle, odometry and closures between the laps", 0, 300},
      {"walk2d", "a walk on a grid in the plane, with closures", 0, 1000},
      {"walk3d", "a walk through three floors, with closures", 0, 1000},
  };
  return scenarios;
}

Simulation simulate(const SimulationOptions& asked) {
  const SimulationOptions options = checked(asked);
  Instance instance = instance_of(options);
  Simulation simulation;
  simulation.dataset = to_dataset(with_ranges(instance.graph), instance.start, Format::G2o);
  simulation.truth = std::move(instance.truth);
  Disturber(options, simulation).disturb();
  return simulation;
}

}  // namespace holdfast::bench
