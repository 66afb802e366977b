// A Window that lives through anything: measurements on time, late, missing and taken back, agents that come and go, clocks that jump,
// saves and restores. Beside it, the plain list of what it was told, solved as a batch from scratch: linear factors with the loss Squared
// are exactly the same problem, so the newest states agree.
//
// Source: below(n), 0 … n − 1; small(), a number of a few metres; empty(), no more steps. Wrong: called with what is wrong.
#pragma once

#include <algorithm>
#include <cmath>
#include <holdfast/factors/huber_measurement.hpp>
#include <holdfast/factors/position_step.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/white_acceleration.hpp>
#include <holdfast/solvers/table.hpp>
#include <holdfast/solvers/window/window.hpp>
#include <set>

namespace holdfast::testing {

template <class Source, class Wrong>
class WindowLife {
 public:
  WindowLife(Source& source, Wrong wrong, std::string path = {})
      : source_(source), wrong_(std::move(wrong)), path_(std::move(path)), lag_(3 + source_.below(8)), window_(options()) {}

  void live(int steps) {
    join();
    for (int i = 0; i < steps && !source_.empty(); ++i) change();
    step(now_);
    compare();
  }
  int compared() const { return compared_; }

 private:
  static constexpr double kDt = 0.125;  // [s] exact in binary
  static constexpr int kAgents = 3;
  using Motion = WhiteAcceleration<Motion2>;
  using Position = HuberMeasurement<Motion2>;
  using Together = PositionStep<Motion2, Motion2>;

  /// A state as the batch knows it: the life of an agent (it may come back), and the tick.
  struct Place {
    int life;
    int tick;
    bool operator<(const Place& other) const { return life != other.life ? life < other.life : tick < other.tick; }
  };
  struct Measurement {
    FactorId id;
    Place first, second;  ///< the same: a position
    Vector<2> z;
  };
  struct AgentLife {
    char letter;
    int first_tick;
    Vector<2> start;
  };

  WindowOptions options() const {
    WindowOptions options;
    options.lag = lag_ * kDt;
    options.solver.cost_tolerance = 0;
    options.solver.gradient_tolerance = 1e-9;
    return options;
  }
  static Motion motion(int ticks = 1) { return Motion::exact(kDt, ticks, 0.7 * Matrix<4, 4>::Identity() + 0.1 * Matrix<4, 4>::Ones()); }
  static Position position(const Vector<2>& z) { return Position::of_position(-z, Vector<2>(0, 0), 0.25 * Matrix<2, 2>::Identity()); }
  static Together together() { return {0.5}; }
  static Prior<Motion2> start_prior(const Vector<2>& p) { return Prior<Motion2>::from_sigmas(Motion2(p[0], 0, p[1], 0), {1, 1, 1, 1}); }
  static char letter(int agent) { return static_cast<char>('A' + agent); }

  void change() {
    switch (source_.below(20)) {
      case 0:
      case 1:
      case 2:
      case 3:
      case 4:
        return measure(now_);
      case 5:
      case 6:
        return measure(now_ - source_.below(lag_ + 3));
      case 7:
        return at(any_agent(), now_), void();  // expected, and missing
      case 8:
      case 9:
      case 10:
      case 11:
        return step(now_ += 1 + source_.below(3));
      case 12:
        return step(now_ - source_.below(20));  // the clock jumps back
      case 13:
      case 14:
        return meet(now_ - source_.below(2));
      case 15:
      case 16:
        return take_back();
      case 17:
        return join();
      case 18:
        return source_.below(3) == 0 ? part() : compare();
      case 19:
        return source_.below(2) == 0 ? off_grid() : save_and_restore();
    }
  }

  int any_agent() { return source_.below(kAgents); }

  /// The window's state at a tick. Whether it is refused is known beforehand.
  std::optional<Key> at(int agent, int tick) {
    if (lives_[agent] < 0) return std::nullopt;
    const double time = tick * kDt;
    const auto states = window_.states(letter(agent));
    const bool refused = window_.newest_time() - time >= lag_ * kDt || time < window_.time(states.front());
    try {
      const Key key = window_.at(letter(agent), time);
      if (refused) wrong_("a time outside the lag was taken");
      return key;
    } catch (const BadTime& error) {
      if (!refused) wrong_(std::string("a time inside the lag was refused: ") + error.what());
      return std::nullopt;
    }
  }
  Place place(int agent, int tick) const { return {lives_[agent], tick}; }

  void measure(int tick) {
    const int agent = any_agent();
    if (const auto key = at(agent, tick)) {
      const Vector<2> z(source_.small(), source_.small());
      measurements_.push_back({window_.add(position(z), {*key}, Squared{}), place(agent, tick), place(agent, tick), z});
    }
  }
  void meet(int tick) {
    const int one = any_agent(), other = any_agent();
    if (one == other || lives_[one] < 0 || lives_[other] < 0 || !at(one, tick)) return;
    if (const auto second = at(other, tick)) {
      const auto first = at(one, tick);
      if (!first) return wrong_("a state is gone that was there just before");
      measurements_.push_back({window_.add(together(), {*first, *second}, Squared{}), place(one, tick), place(other, tick), {}});
    }
  }
  void take_back() {
    if (measurements_.empty()) return;
    const std::size_t which = measurements_.size() - 1 -
                              static_cast<std::size_t>(source_.below(static_cast<int>(std::min<std::size_t>(measurements_.size(), 30))));
    if (!window_.graph().contains(measurements_[which].id)) return;  // it has become part of a prior
    window_.remove(measurements_[which].id);
    measurements_.erase(measurements_.begin() + static_cast<std::ptrdiff_t>(which));
  }
  void join() {
    const int agent = any_agent();
    if (lives_[agent] >= 0) return;
    const Vector<2> start(source_.small(), source_.small());
    window_.add_agent(letter(agent), motion(), kDt);
    const Key key(letter(agent), 0);
    window_.add_state(key, now_ * kDt, Motion2(start[0], 0, start[1], 0));
    window_.add(start_prior(start), {key}, Squared{});
    lives_[agent] = static_cast<int>(all_.size());
    all_.push_back({letter(agent), now_, start});
  }
  void part() {
    const int agent = any_agent();
    if (lives_[agent] < 0) return;
    window_.remove_agent(letter(agent));
    lives_[agent] = -1;
  }
  void step(int tick) {
    const WindowStep& result = window_.step(tick * kDt);
    if (!result.summary.usable() || !result.removed.empty()) wrong_("a step failed: " + result.summary.str());
  }
  void save_and_restore() {
    if (path_.empty()) return;
    window_.save(path_, "note");
    Window other(options());
    for (int agent = 0; agent < kAgents; ++agent)
      if (lives_[agent] >= 0) other.add_agent(letter(agent), motion(), kDt);
    if (other.restore(path_) != "note") wrong_("a note is not the one that was saved");
    window_ = std::move(other);
    for (Measurement& m : measurements_) m.id = {};  // the ids of before name nothing now
  }
  /// A time that the agent's motion has no step to: refused without a trace.
  void off_grid() {
    const int agent = any_agent();
    if (lives_[agent] < 0) return;
    const auto states = window_.states(letter(agent));
    const std::uint64_t structure = window_.graph().structure();
    try {
      window_.at(letter(agent), (now_ + 0.5) * kDt);
      wrong_("a time off the grid was taken");
    } catch (const BadTime&) {
    }
    if (window_.states(letter(agent)) != states || window_.graph().structure() != structure) wrong_("a refused time left a trace");
  }

  /// Everything that was ever told, from scratch.
  Values batch() const {
    std::set<Place> places;
    for (std::size_t life = 0; life < all_.size(); ++life) places.insert({static_cast<int>(life), all_[life].first_tick});
    for (const Measurement& m : measurements_) places.insert({m.first, m.second});
    for (int agent = 0; agent < kAgents; ++agent)
      if (lives_[agent] >= 0) places.insert(place(agent, newest_tick(agent)));
    Graph graph;
    Values values;
    const auto key = [](const Place& p) {
      return Key(static_cast<char>('a' + p.life % 26), static_cast<std::uint64_t>(p.life) * 1000000 + static_cast<std::uint64_t>(p.tick));
    };
    const Place* before = nullptr;
    for (const Place& p : places) {
      const AgentLife& life = all_[static_cast<std::size_t>(p.life)];
      values.insert(key(p), Motion2(life.start[0], 0, life.start[1], 0));
      if (before == nullptr || before->life != p.life)
        graph.add(start_prior(life.start), {key(p)}, Squared{});
      else
        graph.add(motion(p.tick - before->tick), {key(*before), key(p)}, Squared{});
      before = &p;
    }
    for (const Measurement& m : measurements_) {
      const bool alone = m.first.life == m.second.life;
      if (alone)
        graph.add(position(m.z), {key(m.first)}, Squared{});
      else
        graph.add(together(), {key(m.first), key(m.second)}, Squared{});
    }
    make_backend("irls", options().solver)->solve(graph, values);
    Values newest;
    for (int agent = 0; agent < kAgents; ++agent)
      if (lives_[agent] >= 0) newest.insert(Key(letter(agent), 0), values.at<Motion2>(key(place(agent, newest_tick(agent)))));
    return newest;
  }
  int newest_tick(int agent) const { return static_cast<int>(std::lround(window_.time(window_.newest_key(letter(agent))) / kDt)); }

  void compare() {
    step(now_);
    const Values expected = batch();
    for (int agent = 0; agent < kAgents; ++agent) {
      if (lives_[agent] < 0) continue;
      const Motion2& there = expected.at<Motion2>(Key(letter(agent), 0));
      const double difference = (window_.template newest<Motion2>(letter(agent)).value - there.value).norm();
      if (!(difference <= 1e-6 * (1 + there.value.norm())))
        wrong_("agent " + std::string(1, letter(agent)) + " is " + std::to_string(difference) + " from the batch solution, of " +
               std::to_string(measurements_.size()) + " measurements");
      ++compared_;
    }
  }

  Source& source_;
  Wrong wrong_;
  std::string path_;
  int lag_;  ///< [ticks]
  Window window_;
  int now_ = 0;
  int lives_[kAgents] = {-1, -1, -1};  ///< of each agent: its place in all_
  std::vector<AgentLife> all_;
  std::vector<Measurement> measurements_;
  int compared_ = 0;
};

}  // namespace holdfast::testing
