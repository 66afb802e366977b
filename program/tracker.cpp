#include <algorithm>
#include <cmath>
#include <holdfast/adapters/files/edge_to_factor.hpp>
#include <holdfast/adapters/files/vertex_value.hpp>
#include <holdfast/graph/starts/start.hpp>
#include <holdfast/program/pyfg_lines.hpp>
#include <holdfast/program/tracker.hpp>
#include <holdfast/solvers/table.hpp>

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
    line_number_ = number;
    line_text_ = text;
    if (!take(edge)) waiting_.push_back({number, time, std::string(text), edge});
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
    if (!has(key) && (is_sought(key, edge.distance) || !make_landmark(key))) return false;
  return true;
}

template <class E>
bool Tracker::add(const E& edge, double time) {
  if (!prepare(edge, time)) return add_odometry(edge, time);
  const std::vector<Key> keys = keys_of(edge);
  if (keys.size() == 1) {
    put(edge, Loss{});
  } else if (options_.trust) {
    const bool believed = trust_.is_believed(party(keys[0])) && trust_.is_believed(party(keys[1]));
    if (!believed) ++counts_.withheld;
    hear(edge, time, believed ? put(edge, options_.loss) : FactorId{});
  } else {
    put(edge, options_.loss);
  }
  return true;
}

FactorId Tracker::put(const Measurement& measurement, const Loss& loss) {
  return edge_to_factor(measurement, window_.values(),
                        [&](const auto& factor, auto... keys) { return window_.add(factor, {keys...}, loss); });
}

// ---- trust

std::uint64_t Tracker::party(Key key) const { return window_.has_agent(key.agent()) ? key.agent().bits() : key.bits(); }

void Tracker::hear(const Measurement& measurement, double time, FactorId id) {
  const std::vector<Key> keys = keys_of(measurement);
  heard_.push_back({line_number_, time, line_text_, id, keys[0], keys[1]});
}

// At the answer; of one that is withheld, given what is known without it.
bool Tracker::fits(const Heard& one, std::optional<Marginals>& marginals) const {
  if (one.id.number >= 0) {
    const Eigen::VectorXd r = window_.graph().residual(one.id, window_.values());
    return trust_.fits(r.squaredNorm(), static_cast<int>(r.size()));
  }
  return fits_what_is_known(one, marginals);
}

bool Tracker::fits_what_is_known(const Heard& one, std::optional<Marginals>& marginals) const {
  if (!marginals) marginals.emplace(window_.graph(), window_.values());
  const Dataset dataset = parse_line(one.number, one.text, "");
  Graph alone;
  const FactorId id = edge_to_factor(dataset.edges.front().measurement, window_.values(),
                                     [&](const auto& factor, auto... keys) { return alone.add(factor, {keys...}); });
  const auto dim = static_cast<int>(alone.residual(id, window_.values()).size());
  return trust_.fits(innovation(alone, window_.values(), *marginals), dim);
}

// After a step: each new measurement, and what follows from it.
void Tracker::judge() {
  if (!window_.last_step().summary.usable()) return;
  std::optional<Marginals> marginals;
  bool changed = false;
  for (std::size_t i = 0; i < heard_.size(); ++i) {
    Heard& one = heard_[i];
    if (one.is_judged || !has(one.first) || !has(one.second)) continue;
    one.is_judged = true;
    if (one.id.number >= 0 && !window_.graph().contains(one.id)) continue;
    bool does_fit = fits(one, marginals);
    if (!does_fit && one.id.number >= 0 && fits_what_is_known(one, marginals)) {  // the state has drifted: the loss let go of what is right
      window_.remove(one.id);
      one.id = put(parse_line(one.number, one.text, "").edges.front().measurement, Huber{2});
      does_fit = changed = true;
    }
    changed = judge(one, does_fit) || changed;
  }
  while (!heard_.empty() && now_ - heard_.front().time > memory()) heard_.pop_front();
  if (changed) window_.step(now_);
}

// Judged for both ends as long as both are believed, else for those that are not.
bool Tracker::judge(Heard& one, bool fits) {
  const bool both = is_believed(one);
  bool changed = false;
  for (const Key key : {one.first, one.second}) {
    const std::uint64_t who = party(key);
    if (!both && trust_.is_believed(who)) continue;
    const Trust::Change change = trust_.judge(who, one.number, fits);
    if (change == Trust::Change::regained && !fit_together(who)) {
      trust_.disbelieve(who);
      continue;
    }
    if (change == Trust::Change::lost) withhold(who, key);
    if (change == Trust::Change::regained) bring_back(who, key);
    changed = changed || change != Trust::Change::none;
  }
  return changed;
}

void Tracker::withhold(std::uint64_t party, Key key) {
  for (const Trust::Judged& doubtful : trust_.doubtful(party))
    for (Heard& one : heard_) {
      if (one.number != doubtful.ticket || one.id.number < 0) continue;
      if (window_.graph().contains(one.id)) window_.remove(one.id);
      one.id = {};
      ++counts_.withheld;
    }
  const std::string name = window_.has_agent(key.agent()) ? key.agent().str() : key.str();
  options_.say("t = " + std::to_string(now_) + " s: most of what " + name + " measures does not fit; it is withheld from here on");
}

// Its latest measurements with all that is known: as many fit, within the plain gate, as are to fit.
bool Tracker::fit_together(std::uint64_t party) const {
  Graph graph = window_.graph();
  Values values = window_.values();
  std::vector<FactorId> tried;
  for (const Trust::Judged& latest : trust_.latest(party))
    for (const Heard& one : heard_) {
      if (one.number != latest.ticket || one.id.number >= 0 || !has(one.first) || !has(one.second)) continue;
      const Dataset dataset = parse_line(one.number, one.text, "");
      tried.push_back(edge_to_factor(dataset.edges.front().measurement, values,
                                     [&](const auto& factor, auto... keys) { return graph.add(factor, {keys...}, Huber{1}); }));
    }
  if (tried.empty() || !make_backend("irls", options_.window.solver)->solve(graph, values).usable()) return false;
  const auto count = std::count_if(tried.begin(), tried.end(), [&](FactorId id) {
    const Eigen::VectorXd r = graph.residual(id, values);
    return trust_.fits(r.squaredNorm(), static_cast<int>(r.size()));
  });
  return static_cast<double>(count) >= trust_.options().regained * static_cast<double>(tried.size());
}

// What fits, given all that is known: under a convex loss, since the state has drifted.
void Tracker::bring_back(std::uint64_t party, Key key) {
  for (const Trust::Judged& latest : trust_.latest(party))
    for (Heard& one : heard_) {
      if (one.number != latest.ticket || !latest.fits || one.id.number >= 0 || !is_believed(one) || !has(one.first) || !has(one.second))
        continue;
      one.id = put(parse_line(one.number, one.text, "").edges.front().measurement, Huber{2});
      --counts_.withheld;
    }
  const std::string name = window_.has_agent(key.agent()) ? key.agent().str() : key.str();
  options_.say("t = " + std::to_string(now_) + " s: what " + name + " measures fits again; it is believed");
}

template <class V>
bool Tracker::add_odometry(const RelativePoseEdge<V>& edge, double time) {
  if (edge.first.agent() != edge.second.agent() || !has(edge.first)) return false;
  window_.add_state(edge.second, time_of(edge.second, time), edge.first, to_factor(edge));
  return true;
}

// Its start is the one that odometry_start draws from all points seen so far.
VertexValue Tracker::drawn(Key key) const {
  Dataset dataset;
  for (const auto& [other, vertex] : points_) dataset.vertices.push_back(vertex);
  return *vertex_value(odometry_start(dataset, options_.seed, options_.landmark_sigma), key);
}

bool Tracker::make_landmark(Key key) {
  if (points_.count(key) == 0) return false;
  const VertexValue start = drawn(key);
  if (const Point2* point = std::get_if<Point2>(&start))
    add_landmark(key, *point, options_.landmark_sigma);
  else
    add_landmark(key, std::get<Point3>(start), options_.landmark_sigma);
  return true;
}

// Four standard deviations of its vertex are less than the range: then the start is on the right side of every mirror.
bool Tracker::is_sought(Key key, double distance) const {
  if (window_.has_agent(key.agent()) || poses_.count(key) != 0) return false;
  return points_.count(key) == 0 || 4 * options_.landmark_sigma > distance;
}

// The ranges that wait for a point, from where their other end is now; those of before from where it was when it left.
void Tracker::seek() {
  constexpr std::size_t kMost = 400;
  std::map<Key, bool> grown;
  for (const Waiting& one : waiting_) {
    const auto* range = std::get_if<RangeEdge>(&one.edge.measurement);
    if (range == nullptr || has(range->first) == has(range->second)) continue;
    const Key from = has(range->first) ? range->first : range->second, to = from == range->first ? range->second : range->first;
    if (!is_sought(to, range->distance)) continue;
    const std::optional<VertexValue> value = vertex_value(window_.values(), from);
    if (!value) continue;
    Sight sight{one.number, Vector<3>::Zero(), range->distance, std::sqrt(range->variance)};
    std::visit([&](const auto& end) { sight.from.head<std::decay_t<decltype(end)>::space_dim>() = end.position(); }, *value);
    std::vector<Sight>& sights = sought_[to];
    const auto known = std::find_if(sights.rbegin(), sights.rend(), [&](const Sight& old) { return old.number == one.number; });
    if (known != sights.rend()) {
      *known = sight;
      continue;
    }
    if (sights.size() == kMost) sights.erase(sights.begin());
    sights.push_back(sight);
    grown[to] = true;
  }
  for (const auto& [key, is_new] : grown)
    if (place(key, sought_[key])) sought_.erase(key);
}

bool Tracker::place(Key key, const std::vector<Sight>& sights) {
  constexpr double kVague = 1000;  // [m]
  std::optional<Guess> guess;
  bool in_plane = true;
  if (const auto it = points_.find(key); it != points_.end()) {
    guess = Guess{Vector<3>::Zero(), options_.landmark_sigma};
    const auto look = [&](const auto& vertex) {
      constexpr int space = std::decay_t<decltype(vertex)>::space_dim;
      in_plane = space == 2;
      guess->place.head<space>() = vertex.position();
    };
    std::visit(look, drawn(key));
  } else {
    for (const Agent agent : window_.agents())
      in_plane = in_plane && std::holds_alternative<Pose2>(*vertex_value(window_.values(), window_.newest_key(agent)));
  }
  const std::optional<Vector<3>> found = located(sights, guess, in_plane ? 2 : 3);
  if (!found) return false;
  const auto enter = [&](const auto& at) {
    using P = std::decay_t<decltype(at)>;
    window_.add_landmark(key, at);
    const P believed = guess ? P(guess->place.template head<P::space_dim>().eval()) : at;
    window_.add(Prior<P>::from_sigmas(believed, P::Tangent::Constant(guess ? guess->sigma : kVague)), {key});
  };
  if (in_plane)
    enter(Point2(found->head<2>().eval()));
  else
    enter(Point3(*found));
  options_.say("t = " + std::to_string(now_) + " s: " + key.str() + " is found by " + std::to_string(sights.size()) + " ranges");
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
    if (options_.trust) judge();
    print_newest();
  }
  now_ = time;
}

// What waited for a state that has come by now; what is older than the lag waits no longer.
void Tracker::retry() {
  seek();
  std::deque<Waiting> waiting = std::exchange(waiting_, {});
  for (Waiting& one : waiting) {
    line_number_ = one.number;
    line_text_ = one.text;
    if (take(one.edge)) continue;
    if (now_ - one.time < memory()) {
      waiting_.push_back(std::move(one));
      continue;
    }
    ++counts_.refused;
    last_refusal_ =
        "line " + std::to_string(one.number) + " names a state or landmark that never came, or one that ranges have not placed yet";
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
  note.put<std::uint64_t>(heard_.size());
  for (const Heard& one : heard_) {
    note.put(one.number).put(one.time).put(std::string_view(one.text)).put(one.id.number).put(one.id.generation);
    note.put(one.first).put(one.second).put(one.is_judged);
  }
  note.put<std::uint64_t>(trust_.parties().size());
  for (const auto& [party, state] : trust_.parties()) {
    note.put(party).put(state.is_believed).put<std::uint64_t>(state.latest.size());
    for (const Trust::Judged& one : state.latest) note.put(one.ticket).put(one.fits);
  }
  note.put<std::uint64_t>(sought_.size());
  for (const auto& [key, sights] : sought_) {
    note.put(key).put<std::uint64_t>(sights.size());
    for (const Sight& one : sights) note.put(one.number).put(&one.from, sizeof one.from).put(one.distance).put(one.sigma);
  }
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
    std::string text = note.get_text();
    Edge edge = parse_line(number, text, path).edges.front();
    waiting_.push_back({number, time, std::move(text), std::move(edge)});
  }
  printed_.clear();
  for (std::size_t count = note.get_count(1); count > 0; --count) {
    const Agent agent = Agent::from_bits(note.get<std::uint32_t>());
    printed_[agent] = note.get<double>();
  }
  heard_.clear();
  for (std::size_t count = note.get_count(1); count > 0; --count) {
    Heard one;
    one.number = note.get<std::uint64_t>();
    one.time = note.get<double>();
    one.text = note.get_text();
    one.id.number = note.get<int>();
    one.id.generation = note.get<unsigned>();
    one.first = note.get_key();
    one.second = note.get_key();
    one.is_judged = note.get<bool>();
    heard_.push_back(std::move(one));
  }
  std::map<std::uint64_t, Trust::Party> parties;
  for (std::size_t count = note.get_count(1); count > 0; --count) {
    const auto who = note.get<std::uint64_t>();
    Trust::Party& state = parties[who];
    state.is_believed = note.get<bool>();
    for (std::size_t latest = note.get_count(1); latest > 0; --latest) {
      const auto ticket = note.get<std::uint64_t>();
      state.latest.push_back({ticket, note.get<bool>()});
    }
  }
  trust_.set_parties(std::move(parties));
  sought_.clear();
  if (note.at_end()) return;  // saved before there was such a thing
  for (std::size_t count = note.get_count(1); count > 0; --count) {
    std::vector<Sight>& sights = sought_[note.get_key()];
    for (std::size_t seen = note.get_count(1); seen > 0; --seen) {
      Sight one;
      one.number = note.get<std::uint64_t>();
      std::memcpy(static_cast<void*>(one.from.data()), note.take(sizeof one.from), sizeof one.from);
      one.distance = note.get<double>();
      one.sigma = note.get<double>();
      sights.push_back(one);
    }
  }
}

}  // namespace holdfast::program
