#include <algorithm>
#include <cmath>
#include <holdfast/adapters/files/vertex_value.hpp>
#include <holdfast/common/drawing.hpp>
#include <holdfast/common/metrics.hpp>
#include <holdfast/common/position_covariance.hpp>
#include <holdfast/solvers/outlier_report.hpp>
#include <map>
#include <optional>

namespace holdfast::common {
namespace {

/// T: a rigid motion, homogeneous, that the place is seen after.
std::optional<Drawing::Place> place_of(const Values& values, Key key, const std::optional<Eigen::MatrixXd>& T = std::nullopt) {
  if (!values.contains(key)) return std::nullopt;
  const Values::Slot& slot = values.slot(key);
  const auto& pool = values.pool(slot.pool);
  if (pool.space() < 2) return std::nullopt;
  std::array<double, 3> p{};
  pool.position(slot.index, p.data());
  const Eigen::Index space = pool.space();
  if (T && T->rows() == space + 1) {
    Eigen::Map<Eigen::VectorXd> position(p.data(), space);
    position = (T->topLeftCorner(space, space) * position + T->topRightCorner(space, 1).col(0)).eval();
  }
  return Drawing::Place{p[0], p[1]};
}

/// Every n-th, and the last, so that at most `most` or so are left.
template <class T>
std::vector<T> thinned(const std::vector<T>& all, std::size_t most) {
  const std::size_t stride = all.size() / most + 1;
  if (stride == 1) return all;
  std::vector<T> some;
  for (std::size_t i = 0; i < all.size(); i += stride) some.push_back(all[i]);
  if ((all.size() - 1) % stride != 0) some.push_back(all.back());
  return some;
}

bool is_step(const std::vector<Key>& keys) {
  if (keys[0].agent() != keys[1].agent()) return false;
  const std::uint32_t a = keys[0].step(), b = keys[1].step();
  return a + 1 == b || b + 1 == a;
}

bool is_landmark(const Values& values, Key key) { return std::string(type_name(values, key)).rfind("Point", 0) == 0; }

/// Of every landmark, and of some 25 states of each way: more would hide it.
void add_ellipses(const Graph& graph, const Values& answer, const std::map<std::pair<Agent, bool>, std::vector<Key>>& groups,
                  const std::optional<Eigen::MatrixXd>& T, Drawing& drawing) {
  constexpr std::size_t kOfAWay = 25, kLandmarks = 200;
  if (graph.size() == 0) return;
  const Marginals marginals(graph, answer);
  for (const auto& [group, keys] : groups)
    for (const Key key : thinned(keys, group.second ? kOfAWay : kLandmarks)) {
      std::optional<Eigen::MatrixXd> C = position_covariance(marginals, answer, key);
      if (!C) continue;
      const Eigen::Index space = C->rows();
      if (T && T->rows() == space + 1) {
        const Eigen::MatrixXd R = T->topLeftCorner(space, space);
        C = (R * *C * R.transpose()).eval();
      }
      drawing.ellipses.push_back({*place_of(answer, key, T), (*C)(0, 0), (*C)(0, 1), (*C)(1, 1)});
    }
}

double millimetres(double metres) { return std::round(1e3 * metres) / 1e3; }

double four_digits(double number) {
  if (number == 0 || !std::isfinite(number)) return number;
  const double scale = std::pow(10, 3 - std::floor(std::log10(std::abs(number))));
  return std::round(number * scale) / scale;
}

}  // namespace

Drawing drawing_of(const Graph& graph, const Values& truth, const Values& answer, std::size_t most) {
  const std::optional<Eigen::MatrixXd> T_truth_answer = alignment(truth, answer);
  std::vector<Key> keys = answer.keys();
  std::sort(keys.begin(), keys.end());
  std::map<std::pair<Agent, bool>, Drawing::Track> tracks;
  std::map<std::pair<Agent, bool>, std::vector<Key>> groups;
  for (const Key key : keys) {
    const std::optional<Drawing::Place> estimate = place_of(answer, key, T_truth_answer), known = place_of(truth, key);
    if (!estimate) continue;
    const bool is_way = !is_landmark(answer, key);
    const std::pair<Agent, bool> group(is_way ? key.agent() : Agent(key.kind()), is_way);
    groups[group].push_back(key);
    Drawing::Track& track = tracks[group];
    track.name = is_way ? key.agent().str() : std::string(1, key.kind());
    track.is_way = is_way;
    track.estimate.push_back(*estimate);
    if (known) track.truth.push_back(*known);
  }
  Drawing drawing;
  for (auto& [agent, track] : tracks) {
    track.estimate = thinned(track.estimate, most);
    track.truth = thinned(track.truth, most);
    drawing.tracks.push_back(std::move(track));
  }
  for (const MeasurementReport& one : outlier_report(graph, answer)) {
    if (one.keys.size() != 2) continue;
    const std::optional<Drawing::Place> from = place_of(answer, one.keys[0], T_truth_answer),
                                        to = place_of(answer, one.keys[1], T_truth_answer);
    if (!from || !to) continue;
    const bool is_rejected = one.verdict == MeasurementReport::Verdict::outlier;
    if (is_rejected || !is_step(one.keys)) (is_rejected ? drawing.rejected : drawing.kept).push_back({*from, *to, one.factor});
  }
  drawing.kept = thinned(drawing.kept, most);
  add_ellipses(graph, answer, groups, T_truth_answer, drawing);
  return drawing;
}

Json to_json(const Drawing& drawing) {
  const auto places = [](const std::vector<Drawing::Place>& all) {
    Json list = Json::array();
    for (const Drawing::Place& p : all) list.push_back({millimetres(p[0]), millimetres(p[1])});
    return list;
  };
  Json json{{"tracks", Json::array()}, {"rejected", Json::array()}, {"ellipses", Json::array()}};
  for (const Drawing::Track& track : drawing.tracks)
    json["tracks"].push_back(
        {{"name", track.name}, {"is_way", track.is_way}, {"estimate", places(track.estimate)}, {"truth", places(track.truth)}});
  for (const Drawing::Line& line : drawing.rejected)
    json["rejected"].push_back({millimetres(line.from[0]), millimetres(line.from[1]), millimetres(line.to[0]), millimetres(line.to[1])});
  for (const Drawing::Ellipse& one : drawing.ellipses)
    json["ellipses"].push_back(
        {millimetres(one.centre[0]), millimetres(one.centre[1]), four_digits(one.xx), four_digits(one.xy), four_digits(one.yy)});
  return json;
}

}  // namespace holdfast::common
