#include <holdfast/benchmarks/papers/missing_map.hpp>
#include <holdfast/benchmarks/papers/polish.hpp>
#include <holdfast/factors/position_step.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/solvers/table.hpp>

namespace holdfast::bench {
namespace {

constexpr double kTolerance = 0;  // to the last digit: every back-end gives the same numbers

template <int S>
using Point = Kinematic<double, S, 1>;

/// Everything at the middle of the anchors.
template <int S>
Vector<S> centre(const typename Network<S>::Step& step) {
  Vector<S> sum = Vector<S>::Zero();
  for (const Vector<S>& anchor : step.anchors) sum += anchor;
  return sum / static_cast<double>(step.anchors.size());
}

void solve_to_the_end(const Graph& graph, Values& values, const std::string& backend) {
  Options options;
  options.cost_tolerance = kTolerance;
  const Summary summary = make_backend(backend, options)->solve(graph, values);
  Polish()(graph, values, summary);
  if (!summary.usable()) fail<BadProblem>("paper C's estimator under ", backend, ": ", summary.why());
}

template <int S>
std::vector<Vector<S>> nodes_of(const Values& values, int nodes, int step) {
  std::vector<Vector<S>> positions;
  for (int i = 0; i < nodes; ++i) positions.push_back(values.at<Point<S>>(node_key(i, step)).value);
  return positions;
}

template <int S>
std::vector<Vector<S>> one_step(const Network<S>& network, int k, Missing missing, const std::vector<Vector<S>>& previous,
                                const std::string& backend) {
  Graph graph;
  Values values;
  const int nodes = static_cast<int>(network.steps[k].nodes.size());
  for (int i = 0; i < nodes; ++i) {
    values.insert(node_key(i, k), Point<S>(k == 0 ? centre<S>(network.steps[k]) : previous[i]));
    if (k > 0) graph.add(Prior<Point<S>>::from_sigmas(Point<S>(previous[i]), Vector<S>::Constant(network.longest_step)), {node_key(i, k)});
  }
  add_packets<Point<S>>(network, k, missing, graph, values);
  solve_to_the_end(graph.relaxed(), values, backend);
  return nodes_of<S>(values, nodes, k);
}

template <int S>
Tracks<S> all_steps(const Network<S>& network, Missing missing, const std::string& backend) {
  MapProblem problem = map_problem(network, missing);
  solve_to_the_end(problem.graph, problem.start, backend);
  Tracks<S> tracks;
  for (int k = 0; k < static_cast<int>(network.steps.size()); ++k)
    tracks.push_back(nodes_of<S>(problem.start, static_cast<int>(network.steps[0].nodes.size()), k));
  return tracks;
}

}  // namespace

template <int S>
MapProblem map_problem(const Network<S>& network, Missing missing) {
  Graph graph;
  Values values;
  const int steps = static_cast<int>(network.steps.size()), nodes = static_cast<int>(network.steps[0].nodes.size());
  for (int k = 0; k < steps; ++k) {
    for (int i = 0; i < nodes; ++i) {
      values.insert(node_key(i, k), Point<S>(centre<S>(network.steps[k])));
      if (k > 0) graph.add(PositionStep<Point<S>, Point<S>>{network.longest_step}, {node_key(i, k - 1), node_key(i, k)});
    }
    add_packets<Point<S>>(network, k, missing, graph, values);
  }
  return {graph.relaxed(), std::move(values)};
}

template <int S>
Tracks<S> missing_map(const Network<S>& network, const MissingMap& form, const std::string& backend) {
  if (form.previous == MissingMap::Previous::free) return all_steps(network, form.missing, backend);
  Tracks<S> tracks;
  for (int k = 0; k < static_cast<int>(network.steps.size()); ++k)
    tracks.push_back(one_step(network, k, form.missing, k == 0 ? std::vector<Vector<S>>() : tracks.back(), backend));
  return tracks;
}

template <int S>
double omega_error(const Network<S>& network) {
  double sum = 0;
  int lost = 0;
  for (const auto& step : network.steps)
    for (const auto& packet : step.packets)
      if (!packet.received) {
        sum += (packet.distance - packet.previous) * (packet.distance - packet.previous);
        ++lost;
      }
  return std::sqrt(sum / lost);
}

template Tracks<2> missing_map<2>(const Network<2>&, const MissingMap&, const std::string&);
template Tracks<3> missing_map<3>(const Network<3>&, const MissingMap&, const std::string&);
template MapProblem map_problem<2>(const Network<2>&, Missing);
template MapProblem map_problem<3>(const Network<3>&, Missing);
template double omega_error<2>(const Network<2>&);
template double omega_error<3>(const Network<3>&);

}  // namespace holdfast::bench
