#include <algorithm>
#include <holdfast/adapters/files/report.hpp>
#include <map>
#include <set>
#include <sstream>

namespace holdfast {
namespace {

std::string counted(std::size_t n, const char* one, const char* many) { return std::to_string(n) + ' ' + (n == 1 ? one : many); }

struct Counts {
  std::size_t odometry = 0, backwards = 0, loops = 0, switched = 0;
  std::size_t points = 0, ranges = 0, bearings = 0, poses = 0, positions = 0, landmarks = 0, steps = 0;
};

template <class V>
void count(const RelativePoseEdge<V>& edge, const Edge& whole, bool is_odometry, Counts& counts) {
  if (V::dim == V::space_dim) {
    ++counts.steps;
  } else if (is_odometry) {
    ++counts.odometry;
    if (edge.second < edge.first) ++counts.backwards;
  } else {
    ++counts.loops;
    const std::string_view tag = whole.tag;
    if (tag.find("_SWITCHABLE") != std::string_view::npos || tag.find("_MAXMIX") != std::string_view::npos) ++counts.switched;
  }
}
template <class P>
void count(const RelativePointEdge<P>&, const Edge&, bool, Counts& counts) {
  ++counts.points;
}
void count(const RangeEdge&, const Edge&, bool, Counts& counts) { ++counts.ranges; }
void count(const BearingEdge&, const Edge&, bool, Counts& counts) { ++counts.bearings; }
template <class V>
void count(const PriorEdge<V>&, const Edge&, bool, Counts& counts) {
  ++(V::dim > V::space_dim ? counts.poses : counts.landmarks);
}
template <class P>
void count(const PositionEdge<P>&, const Edge&, bool, Counts& counts) {
  ++counts.positions;
}

/// "1, 2, 3 and 7 more".
template <class T, class Text>
std::string listed(const std::vector<T>& all, const Text& text, std::size_t most = 5) {
  std::string list;
  for (std::size_t i = 0; i < std::min(all.size(), most); ++i) list += (i > 0 ? ", " : "") + text(all[i]);
  if (all.size() > most) list += " and " + std::to_string(all.size() - most) + " more";
  return list;
}

void find_unknown_fixed(const Dataset& dataset, std::vector<Finding>& findings) {
  std::set<Key> known;
  for (const Vertex& vertex : dataset.vertices) known.insert(vertex.key);
  for (const Edge& edge : dataset.edges)
    for (Key key : keys_of(edge.measurement)) known.insert(key);
  std::vector<Key> unknown;
  bool any = false;
  for (const Fixed& fixed : dataset.fixed) {
    if (known.count(fixed.key) != 0)
      any = true;
    else
      unknown.push_back(fixed.key);
  }
  if (unknown.empty()) return;
  const std::string names = listed(unknown, [](Key key) { return key.agent() == 'x' ? std::to_string(key.step()) : key.str(); });
  findings.push_back({Finding::Kind::unknown_fixed, Finding::Severity::warning,
                      "FIX " + names + (unknown.size() == 1 ? " names no vertex" : " name no vertex") + " and no end of an edge; " +
                          (any ? "only the others are held" : "without it the first pose is held, as where no FIX line is") +
                          ": correct the id",
                      unknown});
}

void find_times(const Dataset& dataset, std::vector<Finding>& findings) {
  std::map<Key, double> times;
  for (const Vertex& vertex : dataset.vertices)
    if (vertex.time && (std::holds_alternative<Pose2>(vertex.value) || std::holds_alternative<Pose3>(vertex.value)))
      times.emplace(vertex.key, *vertex.time);
  std::vector<std::pair<Key, Key>> equal, decreasing;
  for (auto it = times.begin(); it != times.end(); ++it) {
    const auto next = std::next(it);
    if (next == times.end() || next->first.agent() != it->first.agent() || next->second > it->second) continue;
    (next->second < it->second ? decreasing : equal).emplace_back(it->first, next->first);
  }
  const auto report = [&](const std::vector<std::pair<Key, Key>>& pairs, const char* what, const char* cure) {
    if (pairs.empty()) return;
    const auto& [first, second] = pairs.front();
    std::ostringstream text;
    text.precision(17);
    text << counted(pairs.size(), "pose", "poses") << ' ' << what
         << " the pose before: " << listed(pairs, [](const auto& pair) { return pair.second.str() + " after " + pair.first.str(); }) << " ("
         << first.str() << " at " << times.at(first) << " s, " << second.str() << " at " << times.at(second) << " s); " << cure;
    std::vector<Key> keys;
    for (const auto& pair : pairs) keys.push_back(pair.second);
    findings.push_back({Finding::Kind::bad_time, Finding::Severity::warning, text.str(), keys});
  };
  report(equal, "at the same time as", "a TUM file gives the later one the next time there is: give each a time of its own");
  report(decreasing, "earlier than", "times of an agent grow with its steps: correct them");
}

void find_repairs(const Dataset& dataset, std::vector<Finding>& findings) {
  if (dataset.repairs.empty()) return;
  std::ostringstream text;
  text << counted(dataset.repairs.size(), "indefinite matrix was", "indefinite matrices were")
       << " replaced by the nearest semidefinite one: "
       << listed(
              dataset.repairs,
              [](const Repair& one) {
                std::ostringstream line;
                line << "line " << one.line << " (smallest eigenvalue " << one.smallest << ", moved by " << 100 * one.moved << " %)";
                return line.str();
              },
              dataset.repairs.size());
  findings.push_back({Finding::Kind::repaired_noise, Finding::Severity::warning, text.str(), {}});
}

void find_no_noise(const Dataset& dataset, std::vector<Finding>& findings) {
  if (dataset.no_noise.empty()) return;
  findings.push_back({Finding::Kind::no_noise,
                      Finding::Severity::warning,
                      counted(dataset.no_noise.size(), "edge has no information", "edges have no information") +
                          ", it was taken for the identity (1 m, 1 rad): the first in line " + std::to_string(dataset.no_noise.front()),
                      {}});
}

void find_isam_noise(const Dataset& dataset, std::vector<Finding>& findings) {
  if (dataset.format != Format::Toro || dataset.reading.isam_noise != ReadOptions::IsamNoise::root) return;
  for (const Edge& edge : dataset.edges) {
    const std::string_view tag = edge.tag;
    if (tag != "ODOMETRY" && tag != "LANDMARK") continue;
    findings.push_back({Finding::Kind::isam_noise,
                        Finding::Severity::warning,
                        "the numbers after ODOMETRY and LANDMARK were taken for square roots of informations, as iSAM has them: where they "
                        "are covariances (GTSAM's victoria_park.txt) or informations, say --isam-noise covariance or information",
                        {}});
    return;
  }
}

}  // namespace

std::string use_report(const Dataset& dataset, const OdometryRule& rule) {
  const std::vector<bool> odometry = odometry_edges(dataset, rule);
  Counts n;
  for (std::size_t i = 0; i < odometry.size(); ++i)
    std::visit([&](const auto& edge) { count(edge, dataset.edges[i], odometry[i], n); }, dataset.edges[i].measurement);
  std::string text;
  const auto say = [&](std::size_t number, const char* one, const char* many, const std::string& more = {}) {
    if (number == 0) return;
    text += (text.empty() ? "" : ", ") + counted(number, one, many) + more;
  };
  const auto part = [](std::size_t some, std::size_t all, const char* what) {
    if (some == 0) return std::string();
    return some == all ? std::string(" (") + what + ")" : " (" + std::to_string(some) + ' ' + what + ")";
  };
  say(n.odometry, "odometry edge", "odometry edges", part(n.backwards, n.odometry, "written backwards"));
  say(n.loops, "loop closure", "loop closures", part(n.switched, n.loops, "with a switch or mixture, under the loss instead"));
  say(n.steps, "relative position", "relative positions");
  say(n.points, "landmark sighting", "landmark sightings");
  say(n.bearings, "bearing", "bearings");
  say(n.ranges, "range", "ranges");
  say(n.poses, "pose prior", "pose priors");
  say(n.positions, "position prior", "position priors");
  say(n.landmarks, "landmark prior", "landmark priors");
  if (text.empty()) text = "no measurement";
  const char* mark = "; ";
  for (const UnknownTag& tag : unknown_tags(dataset)) {
    text += mark + counted(tag.count, "line", "lines") + " of " + tag.tag;
    mark = ", ";
  }
  return mark[0] == ',' ? text + " kept, not used" : text;
}

std::vector<Finding> check(const Dataset& dataset) {
  std::vector<Finding> findings;
  find_unknown_fixed(dataset, findings);
  find_times(dataset, findings);
  find_repairs(dataset, findings);
  find_no_noise(dataset, findings);
  find_isam_noise(dataset, findings);
  return findings;
}

}  // namespace holdfast
