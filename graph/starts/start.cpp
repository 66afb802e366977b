#include <deque>
#include <holdfast/graph/detail/random.hpp>
#include <holdfast/graph/require.hpp>
#include <holdfast/graph/starts/start.hpp>
#include <map>
#include <optional>

namespace holdfast {
namespace {

/// The relative poses of one type, and the poses they and the vertices name.
template <class Pose>
class PoseTree {
 public:
  PoseTree(const Dataset& dataset, const std::vector<bool>& is_odometry) {
    for (const Vertex& vertex : dataset.vertices)
      if (const Pose* pose = std::get_if<Pose>(&vertex.value)) nodes_[vertex.key].vertex = *pose;
    for (std::size_t i = 0; i < dataset.edges.size(); ++i) {
      const Measurement& measurement = dataset.edges[i].measurement;
      if (const auto* edge = std::get_if<RelativePoseEdge<Pose>>(&measurement)) {
        nodes_[edge->first].links.push_back({edge, true, is_odometry[i]});
        nodes_[edge->second].links.push_back({edge, false, is_odometry[i]});
      } else if (const auto* prior = std::get_if<PriorEdge<Pose>>(&measurement)) {
        Node& node = nodes_[prior->key];
        if (!node.prior) node.prior = prior->measured;
      } else if (const auto* point = std::get_if<RelativePointEdge<Point>>(&measurement)) {
        nodes_[point->pose];
      }
    }
  }

  void start_at_vertices() {
    for (auto& [key, node] : nodes_)
      if (node.vertex) settle(node, *node.vertex);
  }
  void start_each_agent() {
    for (auto first = nodes_.begin(); first != nodes_.end();) {
      auto chosen = first;
      auto last = first;
      while (last != nodes_.end() && last->first.agent() == first->first.agent()) {
        if (!chosen->second.vertex && last->second.vertex) chosen = last;
        ++last;
      }
      settle(chosen->second, chosen->second.origin());
      first = last;
    }
  }

  /// Gives every pose a value and puts all into `values`.
  void grow(Values& values) {
    spread();
    for (bool vertices_alone : {true, false})
      for (auto& [key, node] : nodes_) {
        if (node.value || (vertices_alone && !node.vertex)) continue;
        settle(node, node.origin());
        spread();
      }
    for (const auto& [key, node] : nodes_) values.insert(key, *node.value);
  }

 private:
  using Point = std::conditional_t<Pose::space_dim == 2, Point2, Point3>;
  struct Link {
    const RelativePoseEdge<Pose>* edge;
    bool forward;
    bool is_odometry;
  };
  struct Node {
    std::optional<Pose> vertex, prior, value;
    std::vector<Link> links;
    Pose origin() const { return vertex ? *vertex : prior ? *prior : Pose(); }
  };

  void settle(Node& node, const Pose& value) {
    node.value = value;
    for (const Link& link : node.links)
      if (!link.is_odometry) open_.push_back(link);
    for (auto link = node.links.rbegin(); link != node.links.rend(); ++link)
      if (link->is_odometry) open_.push_front(*link);
  }
  /// Follows the open links to the end, odometry first.
  void spread() {
    while (!open_.empty()) {
      const Link link = open_.front();
      open_.pop_front();
      const RelativePoseEdge<Pose>& edge = *link.edge;
      Node& target = nodes_.at(link.forward ? edge.second : edge.first);
      if (target.value) continue;
      const Pose& from = *nodes_.at(link.forward ? edge.first : edge.second).value;
      Pose value = from * (link.forward ? edge.measured : edge.measured.inverse());
      settle(target, value.retract(Pose::Tangent::Zero()));  // back to unit length: rounding never accumulates
    }
  }

  std::map<Key, Node> nodes_;
  std::deque<Link> open_;
};

template <class Pose, class Point>
void insert_points(const Dataset& dataset, double sigma, unsigned seed, Values& values) {
  std::map<Key, Point> points;
  for (const Vertex& vertex : dataset.vertices)
    if (const Point* point = std::get_if<Point>(&vertex.value)) points.emplace(vertex.key, *point);
  std::mt19937_64 engine(seed);
  if (sigma > 0)
    for (auto& [key, point] : points)
      for (int axis = 0; axis < Point::dim; ++axis) point.value[axis] += sigma * detail::normal(engine);
  for (const Edge& edge : dataset.edges)
    if (const auto* relative = std::get_if<RelativePointEdge<Point>>(&edge.measurement)) {
      const Pose& pose = values.at<Pose>(relative->pose);
      points.try_emplace(relative->landmark, Point((pose.p + pose.to_world(relative->measured.value)).eval()));
    }
  for (const Edge& edge : dataset.edges)
    if (const auto* prior = std::get_if<PriorEdge<Point>>(&edge.measurement)) points.try_emplace(prior->key, prior->measured);
  for (const auto& [key, point] : points) values.insert(key, point);
}

void require_every_key(const Dataset& dataset, const Values& values) {
  for (const Edge& edge : dataset.edges)
    for (Key key : keys_of(edge.measurement))
      if (!values.contains(key))
        fail<BadKey>(dataset.name, ": ", key.str(), " has no vertex, and ", describe(edge),
                     " does not say where it is; give it a vertex line");
}

template <class Begin>
Values make_start(const Dataset& dataset, double landmark_sigma, unsigned seed, Begin&& begin) {
  const std::vector<bool> is_odometry = odometry_edges(dataset);
  Values values;
  PoseTree<Pose2> plane(dataset, is_odometry);
  PoseTree<Pose3> space(dataset, is_odometry);
  begin(plane);
  begin(space);
  plane.grow(values);
  space.grow(values);
  insert_points<Pose2, Point2>(dataset, landmark_sigma, seed, values);
  insert_points<Pose3, Point3>(dataset, landmark_sigma, seed, values);
  require_every_key(dataset, values);
  return values;
}

}  // namespace

std::vector<bool> odometry_edges(const Dataset& dataset) {
  std::map<Key, Key> next;  // of every pose; built from the sorted poses
  const auto add_pose = [&](Key key) { next.emplace(key, key); };
  for (const Vertex& vertex : dataset.vertices)
    if (std::holds_alternative<Pose2>(vertex.value) || std::holds_alternative<Pose3>(vertex.value)) add_pose(vertex.key);
  const auto ends = [](const Edge& edge) -> std::optional<std::pair<Key, Key>> {
    if (const auto* plane = std::get_if<RelativePoseEdge<Pose2>>(&edge.measurement)) return std::pair{plane->first, plane->second};
    if (const auto* space = std::get_if<RelativePoseEdge<Pose3>>(&edge.measurement)) return std::pair{space->first, space->second};
    return std::nullopt;
  };
  for (const Edge& edge : dataset.edges)
    if (const auto pair = ends(edge)) {
      add_pose(pair->first);
      add_pose(pair->second);
    }
  for (auto it = next.begin(); it != next.end(); ++it)
    if (const auto after = std::next(it); after != next.end() && after->first.agent() == it->first.agent()) it->second = after->first;

  std::vector<bool> is_odometry;
  is_odometry.reserve(dataset.edges.size());
  for (const Edge& edge : dataset.edges) {
    const auto pair = ends(edge);
    is_odometry.push_back(pair && pair->first != pair->second && next.at(pair->first) == pair->second);
  }
  return is_odometry;
}

Values vertex_start(const Dataset& dataset) {
  return make_start(dataset, 0, 0, [](auto& tree) { tree.start_at_vertices(); });
}

Values odometry_start(const Dataset& dataset, unsigned seed, double landmark_sigma) {
  require_not_negative("landmark_sigma", landmark_sigma);
  return make_start(dataset, landmark_sigma, seed, [](auto& tree) { tree.start_each_agent(); });
}

}  // namespace holdfast
