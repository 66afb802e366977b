#include <algorithm>
#include <deque>
#include <holdfast/graph/detail/random.hpp>
#include <holdfast/graph/require.hpp>
#include <holdfast/graph/starts/start.hpp>
#include <map>
#include <optional>
#include <set>
#include <unordered_map>

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
      } else if (const auto* position = std::get_if<PositionEdge<Point>>(&measurement)) {
        nodes_[position->key];
      } else if (const auto* bearing = std::get_if<BearingEdge>(&measurement); bearing != nullptr && Pose::space_dim == 2) {
        nodes_[bearing->pose];
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

/// Landmarks that bearings alone tell of: at the range from the same pose where there is one, else where two bearings meet, else 1 m away.
void add_seen(const Dataset& dataset, const Values& values, std::map<Key, Point2>& points) {
  std::map<std::pair<Key, Key>, double> ranges;
  for (const Edge& edge : dataset.edges)
    if (const auto* range = std::get_if<RangeEdge>(&edge.measurement))
      ranges.emplace(std::pair(range->first, range->second), range->distance);
  struct Ray {
    Vector<2> from, direction;
  };
  std::map<Key, Ray> first;
  std::set<Key> vague;
  for (const Edge& edge : dataset.edges) {
    const auto* bearing = std::get_if<BearingEdge>(&edge.measurement);
    if (bearing == nullptr || (points.count(bearing->landmark) != 0 && vague.count(bearing->landmark) == 0)) continue;
    const Pose2& pose = values.at<Pose2>(bearing->pose);
    const Ray ray{pose.p, pose.to_world({std::cos(bearing->angle), std::sin(bearing->angle)})};
    const auto range = ranges.find({bearing->pose, bearing->landmark});
    if (range != ranges.end()) {
      points[bearing->landmark] = Point2((ray.from + range->second * ray.direction).eval());
      vague.erase(bearing->landmark);
      continue;
    }
    const auto [it, is_new] = first.emplace(bearing->landmark, ray);
    if (is_new) {
      points[bearing->landmark] = Point2((ray.from + ray.direction).eval());
      vague.insert(bearing->landmark);
      continue;
    }
    constexpr double kParallel = 0.05;  // [rad]
    Matrix<2, 2> directions;
    directions << it->second.direction, -ray.direction;
    if (std::abs(directions.determinant()) < kParallel) continue;
    const Vector<2> lengths = directions.inverse() * (ray.from - it->second.from);
    if (lengths.minCoeff() < 0) continue;
    points[bearing->landmark] = Point2((it->second.from + lengths[0] * it->second.direction).eval());
    vague.erase(bearing->landmark);
  }
}
void add_seen(const Dataset&, const Values&, std::map<Key, Point3>&) {}

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
  for (bool grows = true; grows;) {
    grows = false;
    for (const Edge& edge : dataset.edges) {
      const auto* step = std::get_if<RelativePoseEdge<Point>>(&edge.measurement);
      if (step == nullptr || points.count(step->first) == points.count(step->second)) continue;
      const bool forwards = points.count(step->first) != 0;
      const Point& from = points.at(forwards ? step->first : step->second);
      points.emplace(forwards ? step->second : step->first, Point((from.value + (forwards ? 1 : -1) * step->measured.value).eval()));
      grows = true;
    }
  }
  add_seen(dataset, values, points);
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

namespace {

double median(std::vector<double> numbers) {
  if (numbers.empty()) return 0;
  const auto middle = numbers.begin() + static_cast<std::ptrdiff_t>(numbers.size() / 2);
  std::nth_element(numbers.begin(), middle, numbers.end());
  return *middle;
}

std::optional<std::pair<Key, Key>> ends_of(const Measurement& measurement) {
  if (const auto* plane = std::get_if<RelativePoseEdge<Pose2>>(&measurement)) return std::pair{plane->first, plane->second};
  if (const auto* space = std::get_if<RelativePoseEdge<Pose3>>(&measurement)) return std::pair{space->first, space->second};
  return std::nullopt;
}

bool stands_under_a_switch(const Edge& edge) {
  const std::string_view tag = edge.tag;
  return tag.find("_SWITCHABLE") != std::string_view::npos || tag.find("_MAXMIX") != std::string_view::npos;
}

class Consecutive {
 public:
  explicit Consecutive(const Dataset& dataset) : dataset_(dataset) {
    for (const Vertex& vertex : dataset.vertices) {
      if (std::holds_alternative<Pose2>(vertex.value) || std::holds_alternative<Pose3>(vertex.value)) {
        next_.emplace(vertex.key, vertex.key);
        vertices_.emplace(vertex.key, &vertex.value);
      } else {
        others_.insert(vertex.key);
      }
    }
    for (const Edge& edge : dataset.edges)
      if (const auto ends = ends_of(edge.measurement)) {
        next_.emplace(ends->first, ends->first);
        next_.emplace(ends->second, ends->second);
      }
    for (const Edge& edge : dataset.edges)
      for (Key key : keys_of(edge.measurement))
        if (next_.count(key) == 0) others_.insert(key);
    find_next();
  }

  std::vector<bool> edges() {
    std::vector<bool> chosen(dataset_.edges.size(), false);
    std::map<Agent, std::vector<Candidate>> agents;
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      const Edge& edge = dataset_.edges[i];
      const auto ends = ends_of(edge.measurement);
      if (!ends || stands_under_a_switch(edge) || !follows(ends->first, ends->second)) continue;
      chosen[i] = true;
      agents[ends->first.agent()].push_back(compare(i, edge.measurement));
    }
    for (const auto& [agent, candidates] : agents) leave_out_seams(candidates, chosen);
    return chosen;
  }

 private:
  /// How an edge and the vertices of its ends differ.
  struct Candidate {
    std::size_t edge;
    bool has_vertices = false;
    double step = 0;   ///< between the vertices [m]
    double apart = 0;  ///< [m]
    double in_sigmas = 0;
  };

  void find_next() {
    std::map<Agent, std::vector<double>> gaps;
    for (auto it = next_.begin(); it != next_.end(); ++it) {
      const auto after = std::next(it);
      if (after == next_.end() || after->first.agent() != it->first.agent()) continue;
      it->second = after->first;
      gaps[it->first.agent()].push_back(gap(it->first, after->first));
    }
    for (const auto& [agent, all] : gaps) usual_gap_[agent] = median(all);
  }
  /// Steps from one to the next but those that belong to landmarks.
  double gap(Key from, Key to) const {
    double steps = static_cast<double>(to.step()) - static_cast<double>(from.step());
    for (auto it = others_.upper_bound(from); it != others_.end() && *it < to; ++it) --steps;
    return steps;
  }
  bool follows(Key a, Key b) const {
    if (b < a) std::swap(a, b);
    if (a == b || next_.at(a) != b) return false;
    return gap(a, b) <= 5 * usual_gap_.at(a.agent());
  }
  Candidate compare(std::size_t i, const Measurement& measurement) const {
    Candidate candidate{i};
    if (const auto* plane = std::get_if<RelativePoseEdge<Pose2>>(&measurement)) compare(*plane, candidate);
    if (const auto* space = std::get_if<RelativePoseEdge<Pose3>>(&measurement)) compare(*space, candidate);
    return candidate;
  }
  template <class V>
  void compare(const RelativePoseEdge<V>& edge, Candidate& candidate) const {
    const auto first = vertices_.find(edge.first), second = vertices_.find(edge.second);
    if (first == vertices_.end() || second == vertices_.end()) return;
    const V* a = std::get_if<V>(first->second);
    const V* b = std::get_if<V>(second->second);
    if (a == nullptr || b == nullptr) return;
    const V error = edge.measured.inverse() * (a->inverse() * *b);
    const Vector<V::dim> deviation = V().local(error);
    candidate.has_vertices = true;
    candidate.step = (b->p - a->p).norm();
    candidate.apart = error.p.norm();
    candidate.in_sigmas = std::sqrt(std::max(0.0, deviation.dot(edge.information() * deviation)));
  }
  static void leave_out_seams(const std::vector<Candidate>& candidates, std::vector<bool>& chosen) {
    std::vector<double> steps, sigmas;
    for (const Candidate& one : candidates) {
      if (!one.has_vertices) continue;
      steps.push_back(one.step);
      sigmas.push_back(one.in_sigmas);
    }
    const double usual_step = median(steps), usual_sigmas = median(sigmas);
    std::vector<std::size_t> seams;
    for (const Candidate& one : candidates)
      if (one.has_vertices && one.step > 3 * usual_step && one.apart > usual_step && one.in_sigmas > 10 &&
          one.in_sigmas > 10 * usual_sigmas)
        seams.push_back(one.edge);
    if (seams.size() > 2 + candidates.size() / 100) return;
    for (const std::size_t edge : seams) chosen[edge] = false;
  }

  const Dataset& dataset_;
  std::map<Key, Key> next_;  ///< of every pose the next of its agent
  std::set<Key> others_;     ///< that are no poses
  std::map<Agent, double> usual_gap_;
  std::unordered_map<Key, const VertexValue*> vertices_;
};

}  // namespace

OdometryRule odometry_rule(const std::string& text) {
  if (text == "consecutive") return {};
  if (text == "none") return {OdometryRule::Kind::none};
  if (text.empty()) fail<BadOption>("the odometry rule is empty; give consecutive, none, or the tag of its lines");
  return {OdometryRule::Kind::tag, text};
}

std::vector<bool> odometry_edges(const Dataset& dataset, const OdometryRule& rule) {
  if (rule.kind == OdometryRule::Kind::consecutive) return Consecutive(dataset).edges();
  std::vector<bool> chosen(dataset.edges.size(), false);
  if (rule.kind == OdometryRule::Kind::none) return chosen;
  for (std::size_t i = 0; i < chosen.size(); ++i) chosen[i] = ends_of(dataset.edges[i].measurement) && dataset.edges[i].tag == rule.tag;
  if (std::find(chosen.begin(), chosen.end(), true) == chosen.end()) {
    std::set<std::string> tags;
    for (const Edge& edge : dataset.edges)
      if (ends_of(edge.measurement)) tags.insert(edge.tag);
    std::string there_are;
    for (const std::string& tag : tags) there_are += " " + tag;
    fail<BadOption>("no relative pose of ", dataset.name, " has the tag '", rule.tag, "' of the odometry; there are:", there_are,
                    "; or give consecutive or none");
  }
  return chosen;
}

Values vertex_start(const Dataset& dataset) {
  return make_start(dataset, 0, 0, [](auto& tree) { tree.start_at_vertices(); });
}

Values odometry_start(const Dataset& dataset, unsigned seed, double landmark_sigma) {
  require_not_negative("landmark_sigma", landmark_sigma);
  return make_start(dataset, landmark_sigma, seed, [](auto& tree) { tree.start_each_agent(); });
}

}  // namespace holdfast
