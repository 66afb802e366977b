#include <algorithm>
#include <cmath>
#include <holdfast/adapters/files/edge_to_factor.hpp>
#include <holdfast/adapters/files/vertex_value.hpp>
#include <holdfast/graph/starts/start.hpp>
#include <holdfast/program/pyfg_lines.hpp>
#include <holdfast/program/tracker.hpp>

namespace holdfast::program {

Tracker::Tracker(const TrackOptions& options, std::function<void(const Tracked&)> print)
    : options_(options), print_(std::move(print)), window_([&] {
        WindowOptions chosen = options.window;
        chosen.on_leaving = [this](Key key, double time) { this->print(key, time, true); };
        return chosen;
      }()) {}

void Tracker::line(std::uint64_t number, std::string_view text, const std::string& file) {
  ++counts_.lines;
  finished_ = false;
  Dataset one;
  try {
    one = parse_line(number, text, file);
  } catch (const BadFile&) {
    ++counts_.malformed;
    throw;
  }
  for (const Vertex& vertex : one.vertices) take(vertex);
  for (const Edge& edge : one.edges) {
    const double time = time_of(edge);
    if (time > now_) advance(time);
    if (!take(edge)) waiting_.push_back({number, time, std::string(text)});
  }
}

void Tracker::vertices_of(std::uint64_t number, std::string_view text, const std::string& file) {
  try {
    for (const Vertex& vertex : parse_line(number, text, file).vertices) take(vertex);
  } catch (const BadFile&) {  // counted when it was met first
  }
}

void Tracker::take(const Vertex& vertex) {
  const bool is_pose = std::holds_alternative<Pose2>(vertex.value) || std::holds_alternative<Pose3>(vertex.value);
  (is_pose ? poses_ : points_)[vertex.key] = vertex;
}

double Tracker::time_of(Key key, double otherwise) const {
  const auto it = poses_.find(key);
  return it != poses_.end() && it->second.time ? *it->second.time : otherwise;
}

double Tracker::time_of(const Edge& edge) const {
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  double time = kNone;
  for (Key key : keys_of(edge.measurement)) time = std::max(time, time_of(key, kNone));
  return time == kNone ? edge.time.value_or(now_) : time;
}

// ---- measurements

bool Tracker::take(const Edge& edge) {
  const double time = time_of(edge);
  try {
    const bool fits = std::visit([&](const auto& measurement) { return add(measurement, time); }, edge.measurement);
    if (fits) ++counts_.measurements;
    return fits;
  } catch (const BadTime& error) {
    ++counts_.late;
    last_refusal_ = error.what();
  } catch (const Error& error) {
    ++counts_.refused;
    last_refusal_ = error.what();
  }
  return true;
}

template <class V>
void Tracker::start(Key key, double time, const Matrix<V::dim, V::dim>& information) {
  const auto it = poses_.find(key);
  const V* vertex = it == poses_.end() ? nullptr : std::get_if<V>(&it->second.value);
  const V value = vertex != nullptr ? *vertex : V();
  window_.add_state(key, time_of(key, time), value);
  window_.add(Prior<V>::from_information(value, information), {key});
}

template <class V>
bool Tracker::prepare(const RelativePoseEdge<V>& edge, double time) {
  const bool same_agent = edge.first.agent() == edge.second.agent();
  if (same_agent && !window_.has_agent(edge.first.agent())) start<V>(edge.first, time, edge.information());
  return has(edge.first) && has(edge.second);
}

template <class P>
bool Tracker::prepare(const RelativePointEdge<P>& edge, double) {
  if (!has(edge.pose)) return false;
  if (!has(edge.landmark) && !make_landmark(edge.landmark)) {
    constexpr double kVague = 1000;  // [m]: nothing is known of it but what is measured
    const auto& pose = window_.state<PoseFor<P>>(edge.pose);
    add_landmark(edge.landmark, P((pose.p + pose.to_world(edge.measured.value)).eval()), kVague);
  }
  return true;
}

template <class V>
bool Tracker::prepare(const PriorEdge<V>& edge, double time) {
  constexpr bool is_pose = V::dim > V::space_dim;
  if (has(edge.key)) return true;
  if (is_pose && window_.has_agent(edge.key.agent())) return false;
  if (is_pose)
    window_.add_state(edge.key, time_of(edge.key, time), edge.measured);
  else
    window_.add_landmark(edge.key, edge.measured);
  return true;
}

bool Tracker::prepare(const RangeEdge& edge, double) {
  for (Key key : {edge.first, edge.second})
    if (!has(key) && !make_landmark(key)) return false;
  return true;
}

template <class E>
bool Tracker::add(const E& edge, double time) {
  if (!prepare(edge, time)) return add_odometry(edge, time);
  edge_to_factor(edge, window_.values(),
                 [&](const auto& factor, auto... keys) { window_.add(factor, {keys...}, sizeof...(keys) == 1 ? Loss{} : options_.loss); });
  return true;
}

template <class V>
bool Tracker::add_odometry(const RelativePoseEdge<V>& edge, double time) {
  if (edge.first.agent() != edge.second.agent() || !has(edge.first)) return false;
  window_.add_state(edge.second, time_of(edge.second, time), edge.first, to_factor(edge));
  return true;
}

// Its start is the one that odometry_start draws from all points seen so far.
bool Tracker::make_landmark(Key key) {
  if (points_.count(key) == 0) return false;
  Dataset dataset;
  for (const auto& [other, vertex] : points_) dataset.vertices.push_back(vertex);
  const double sigma = options_.landmark_sigma;
  const Values start = odometry_start(dataset, options_.seed, sigma);
  if (start.contains<Point2>(key))
    add_landmark(key, start.at<Point2>(key), sigma);
  else
    add_landmark(key, start.at<Point3>(key), sigma);
  return true;
}

template <class P>
void Tracker::add_landmark(Key key, const P& start, double sigma) {
  window_.add_landmark(key, start);
  window_.add(Prior<P>::from_sigmas(start, P::Tangent::Constant(sigma)), {key});
}

// ---- time

void Tracker::advance(double time) {
  const bool is_first = !std::isfinite(now_);
  if (!is_first) {
    retry();
    const WindowStep& step = window_.step(now_);
    ++counts_.steps;
    if (!step.summary.usable()) ++counts_.failed;
    print_newest();
  }
  now_ = time;
}

// What waited for a state that has come by now; what is older than the lag waits no longer.
void Tracker::retry() {
  std::deque<Waiting> waiting = std::exchange(waiting_, {});
  for (Waiting& one : waiting) {
    const Dataset dataset = parse_line(one.number, one.text, "");
    if (take(dataset.edges.front())) continue;
    if (now_ - one.time < options_.window.lag) {
      waiting_.push_back(std::move(one));
      continue;
    }
    ++counts_.refused;
    last_refusal_ = "line " + std::to_string(one.number) + " names a state or landmark that never came";
  }
}

void Tracker::finish() {
  if (!std::isfinite(now_) || std::exchange(finished_, true)) return;
  advance(now_);
  counts_.refused += waiting_.size();
  waiting_.clear();
  for (const Agent agent : window_.agents())
    for (Key key : window_.states(agent)) print(key, window_.time(key), true);
}

void Tracker::print_newest() {
  for (const Agent agent : window_.agents()) {
    const Key key = window_.newest_key(agent);
    const double time = window_.time(key);
    const auto [it, is_new] = printed_.try_emplace(agent, time);
    if (!is_new && it->second == time) continue;
    it->second = time;
    print(key, time, false);
  }
}

void Tracker::print(Key key, double time, bool leaving) {
  const VertexValue value = *vertex_value(window_.values(), key);
  score(key, value, leaving);
  print_({time, key, value, leaving});
  if (leaving) poses_.erase(key);
}

void Tracker::score(Key key, const VertexValue& value, bool leaving) {
  const auto it = poses_.find(key);
  if (it == poses_.end() || it->second.value.index() != value.index()) return;
  double squared = 0;
  if (const Pose2* pose = std::get_if<Pose2>(&value)) squared = (pose->p - std::get<Pose2>(it->second.value).p).squaredNorm();
  if (const Pose3* pose = std::get_if<Pose3>(&value)) squared = (pose->p - std::get<Pose3>(it->second.value).p).squaredNorm();
  (leaving ? counts_.squared_error_leaving : counts_.squared_error) += squared;
  ++(leaving ? counts_.scored_leaving : counts_.scored);
}

// ---- files

void Tracker::save(const std::string& path) const {
  io::ByteWriter note;
  note.put(now_).put(finished_).put(&counts_, sizeof counts_);
  note.put<std::uint64_t>(waiting_.size());
  for (const Waiting& one : waiting_) note.put(one.number).put(one.time).put(std::string_view(one.text));
  note.put<std::uint64_t>(printed_.size());
  for (const auto& [agent, time] : printed_) note.put(agent.bits()).put(time);
  window_.save(path, note.bytes());
}

void Tracker::restore(const std::string& path) {
  const std::string bytes = window_.restore(path);
  io::ByteReader note(bytes);
  now_ = note.get<double>();
  finished_ = note.get<bool>();
  std::memcpy(&counts_, note.take(sizeof counts_), sizeof counts_);
  waiting_.clear();
  for (std::size_t count = note.get_count(1); count > 0; --count) {
    const auto number = note.get<std::uint64_t>();
    const auto time = note.get<double>();
    waiting_.push_back({number, time, note.get_text()});
  }
  printed_.clear();
  for (std::size_t count = note.get_count(1); count > 0; --count) {
    const Agent agent = Agent::from_bits(note.get<std::uint32_t>());
    printed_[agent] = note.get<double>();
  }
}

}  // namespace holdfast::program
