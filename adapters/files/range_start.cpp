#include <algorithm>
#include <holdfast/adapters/files/range_start.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/graph/starts/start.hpp>
#include <holdfast/solvers/irls/irls.hpp>
#include <map>
#include <set>

namespace holdfast {
namespace {

/// One range to the point that is sought.
template <class Point>
struct Sight {
  Point from;
  double distance, sigma;
};

std::vector<Vector<2>> directions(Point2*) {
  std::vector<Vector<2>> all;
  for (int k = 0; k < 12; ++k) all.emplace_back(std::cos(k * kPi / 6), std::sin(k * kPi / 6));
  return all;
}
std::vector<Vector<3>> directions(Point3*) {
  std::vector<Vector<3>> all;
  for (int x : {-1, 0, 1})
    for (int y : {-1, 0, 1})
      for (int z : {-1, 0, 1})
        if (x != 0 || y != 0 || z != 0) all.push_back(Vector<3>(x, y, z).normalized());
  return all;
}

template <class Point>
Point best_point(const std::vector<Sight<Point>>& sights) {
  constexpr Agent A('a');
  const Key sought('b', 0);
  Graph graph;
  Values start;
  for (std::size_t i = 0; i < sights.size(); ++i) {
    start.insert(A(i), sights[i].from);
    graph.fix(A(i));
    graph.add(Range<Point, Point>{sights[i].distance, sights[i].sigma}, {A(i), sought}, Cauchy{2});
  }
  const auto nearest = std::min_element(sights.begin(), sights.end(), [](const auto& a, const auto& b) { return a.distance < b.distance; });
  start.insert(sought, Point());
  Point best;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& direction : directions(static_cast<Point*>(nullptr))) {
    Values values = start;
    values.update(sought, Point((nearest->from.value + nearest->distance * direction).eval()));
    const Summary summary = Irls(Options()).solve(graph, values);
    if (!summary.usable() || !(summary.cost < least)) continue;
    least = summary.cost;
    best = values.at<Point>(sought);
  }
  return best;
}

/// Keys that some range names and nothing else says a word about.
std::set<Key> known_by_ranges_alone(const Dataset& dataset) {
  std::set<Key> unknown;
  for (const Edge& edge : dataset.edges)
    if (const auto* range = std::get_if<RangeEdge>(&edge.measurement)) unknown.insert({range->first, range->second});
  for (const Vertex& vertex : dataset.vertices) unknown.erase(vertex.key);
  for (const Edge& edge : dataset.edges)
    if (!std::holds_alternative<RangeEdge>(edge.measurement))
      for (Key key : keys_of(edge.measurement)) unknown.erase(key);
  return unknown;
}

template <class Pose, class Point>
void locate(const Dataset& dataset, const std::set<Key>& unknown, const Values& start, std::vector<Vertex>& found) {
  std::map<Key, std::vector<Sight<Point>>> sights;
  for (const Edge& edge : dataset.edges)
    if (const auto* range = std::get_if<RangeEdge>(&edge.measurement))
      for (const auto& [from, to] : {std::pair(range->first, range->second), std::pair(range->second, range->first)}) {
        if (unknown.count(to) == 0) continue;
        const double sigma = std::sqrt(range->variance);
        if (start.contains<Pose>(from)) sights[to].push_back({Point(start.at<Pose>(from).p), range->distance, sigma});
        if (start.contains<Point>(from)) sights[to].push_back({start.at<Point>(from), range->distance, sigma});
      }
  for (const auto& [key, all] : sights) found.push_back({key, best_point(all), {}, {}, 0});
}

}  // namespace

Dataset located_by_ranges(const Dataset& dataset) {
  const std::set<Key> unknown = known_by_ranges_alone(dataset);
  Dataset result = dataset;
  if (unknown.empty()) return result;
  Dataset rest = dataset;  // without what vertex_start cannot place
  rest.edges.erase(std::remove_if(rest.edges.begin(), rest.edges.end(),
                                  [](const Edge& edge) { return std::holds_alternative<RangeEdge>(edge.measurement); }),
                   rest.edges.end());
  const Values start = vertex_start(rest);
  locate<Pose2, Point2>(dataset, unknown, start, result.vertices);
  locate<Pose3, Point3>(dataset, unknown, start, result.vertices);
  return result;
}

}  // namespace holdfast
