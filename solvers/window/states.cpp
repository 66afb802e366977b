// Window: agents come and go, states and landmarks enter, each at its time.
#include <algorithm>
#include <cmath>
#include <holdfast/solvers/window/window.hpp>

namespace holdfast {
namespace {

/// Two stamps that rounding alone tells apart.
bool same_time(double a, double b) {
  constexpr double kNanosecond = 1e-9, kRounding = 1e-15;
  return std::abs(a - b) <= std::max(kNanosecond, kRounding * std::abs(a));
}

}  // namespace

// ---- agents

const Window::Agent* Window::find(char letter) const {
  for (const Agent& agent : agents_)
    if (agent.letter == letter) return &agent;
  return nullptr;
}

const Window::Agent& Window::known(char letter) const {
  const Agent* agent = find(letter);
  if (agent == nullptr) fail<BadKey>("there is no agent ", std::string(1, letter), " in the window; add_agent() or add_state() first");
  return *agent;
}

void Window::enter_agent(char letter, std::unique_ptr<MotionModel> motion) {
  require_no_agent(Key(letter, 0));
  for (Key key : values_.keys())
    if (key.agent() == letter)
      fail<BadKey>("agent ", std::string(1, letter), ": there is a landmark ", key, " of this letter; choose another one");
  agents_.push_back({letter, std::move(motion), {}, 0});
}

void Window::remove_agent(char letter) {
  known(letter);
  gone_.clear();
  for (const State& state : find(letter)->states) {
    if (options_.on_leaving) options_.on_leaving(state.key, state.time);
    leave(state.key);
    gone_.push_back(state.key);
  }
  values_.erase(gone_);
  agents_.erase(agents_.begin() + (find(letter) - agents_.data()));
}

Key Window::newest_key(char letter) const {
  const Agent& agent = known(letter);
  if (agent.states.empty()) fail<BadKey>("agent ", std::string(1, letter), " has no state yet; add_state() its first one");
  return agent.states.back().key;
}

double Window::time(Key key) const {
  const Agent* agent = find(key.agent());
  if (agent != nullptr)
    for (const State& state : agent->states)
      if (state.key == key) return state.time;
  fail<BadKey>("key ", key, " is no state of the window (any more)");
}

std::vector<Key> Window::states(char letter) const {
  std::vector<Key> keys;
  for (const State& state : known(letter).states) keys.push_back(state.key);
  return keys;
}

std::string Window::agents() const {
  std::string letters;
  for (const Agent& agent : agents_) letters += agent.letter;
  return letters;
}

std::unordered_map<Key, double> Window::times() const {
  std::unordered_map<Key, double> all;
  for (const Agent& agent : agents_)
    for (const State& state : agent.states) all.emplace(state.key, state.time);
  return all;
}

// ---- states

void Window::require_time(double time) const {
  if (!std::isfinite(time)) fail<BadTime>("time stamp ", time, " is not finite; leave the measurement out");
  if (std::isfinite(newest_) && time - newest_ > options_.max_gap)
    fail<BadTime>("time stamp ", time, " is ", time - newest_, " s ahead of the newest state; max_gap = ", options_.max_gap,
                  " s. Repair the clock, or start a new window");
  if (newest_ - time >= options_.lag)
    fail<BadTime>("time stamp ", time, " is ", newest_ - time, " s older than the newest state, and the lag is ", options_.lag,
                  " s: what was known then has left the window. Leave the measurement out, or choose a longer lag");
}

void Window::require_no_agent(Key key) const {
  if (has_agent(key.agent()))
    fail<BadKey>("key ", key, ": there is an agent ", std::string(1, key.agent()), " in the window; choose another letter");
}

void Window::fail_unknown(Key key, const std::string& factor) const {
  fail<BadKey>("factor ", factor, ": key ", key,
               " is not in the window: it was never added, has left, or was an empty state merged into one motion; ask at(agent, time)");
}

// Checks first, so that a refused state leaves no trace.
void Window::require_new_state(Key key, double time) const {
  require_time(time);
  if (values_.contains(key)) fail<BadKey>("key ", key, " is in the window already; each state has its own index");
  if (const Agent* agent = find(key.agent())) {
    for (const State& state : agent->states)
      if (same_time(state.time, time))
        fail<BadTime>("key ", key, ": agent ", std::string(1, key.agent()), " has a state at ", time, " s already, ", state.key,
                      "; measure that one");
    return;
  }
  for (Key other : values_.keys())
    if (other.agent() == key.agent()) fail<BadKey>("key ", key, ": there is a landmark ", other, " of this letter; choose another one");
}

// Its value, and the odometry that leads to it, are there already.
void Window::enter_new(Key key, double time, FactorId odometry) {
  if (!has_agent(key.agent())) agents_.push_back({key.agent(), nullptr, {}, 0});
  Agent& agent = *find(key.agent());
  try {
    const Place place = tie(agent, key, time);
    enter(agent, {key, time, place.motion}, place);
  } catch (...) {
    if (odometry.number >= 0) graph_.remove(odometry);
    values_.erase(key);
    throw;
  }
}

// The motion factors come first: they may refuse the times or their own numbers, and then nothing has changed.
// passed_over: states before the new one that its motion leads over.
Window::Place Window::tie(Agent& agent, Key key, double time, int passed_over) {
  const auto after = std::find_if(agent.states.begin(), agent.states.end(), [&](const State& s) { return s.time > time; });
  Place place{static_cast<std::size_t>(after - agent.states.begin()), {}, {}};
  if (!agent.motion) return place;
  if (after != agent.states.begin()) {
    const State& before = *(after - 1 - passed_over);
    place.motion = agent.motion->add(graph_, before.key, key, time - before.time);
  }
  if (after == agent.states.end()) return place;
  try {
    place.onward = agent.motion->add(graph_, key, after->key, after->time - time);
  } catch (...) {
    if (place.motion.number >= 0) graph_.remove(place.motion);
    throw;
  }
  if (after->motion.number >= 0) graph_.remove(after->motion);  // it passed over the new state: split
  return place;
}

void Window::enter(Agent& agent, const State& state, const Place& place) {
  agent.states.insert(agent.states.begin() + static_cast<std::ptrdiff_t>(place.index), state);
  if (place.onward.number >= 0) agent.states[place.index + 1].motion = place.onward;
  agent.next_index = std::max(agent.next_index, state.key.index() + 1);
  newest_ = std::max(newest_, state.time);
}

Key Window::at(char letter, double time) {
  const Lap lap(*this);
  known(letter);
  Agent& agent = *find(letter);
  require_time(time);
  for (auto state = agent.states.rbegin(); state != agent.states.rend() && state->time > time - 1; ++state)
    if (same_time(state->time, time)) return state->key;
  if (agent.states.empty() || time < agent.states.front().time)
    fail<BadTime>("agent ", std::string(1, letter), " at ", time,
                  " s: ", agent.states.empty() ? "it has no state yet" : "its first state is later", "; add_state() tells where it starts");
  if (!agent.motion)
    fail<BadTime>("agent ", std::string(1, letter), " has no state at ", time,
                  " s and no motion to make one from; add_agent() with a motion, or add_state() with odometry");
  const bool merges = time > agent.states.back().time && newest_is_mergeable(agent);
  const Key key(letter, agent.next_index);
  Place place = tie(agent, key, time, merges ? 1 : 0);
  const State& before = agent.states[place.index - (merges ? 2 : 1)];
  agent.motion->insert_predicted(values_, before.key, key, time - before.time);
  if (merges) {
    remove_newest(agent);
    --place.index;
  }
  enter(agent, {key, time, place.motion}, place);
  return key;
}

/// Only its motion touches it.
bool Window::is_empty(const State& state) const {
  int touching = 0;
  for (const auto& batch : graph_.batches()) {
    if (batch->size() == 0) continue;
    const Key* key = batch->keys(0);
    const Key* const end = key + static_cast<std::ptrdiff_t>(batch->size()) * batch->arity();
    touching += static_cast<int>(std::count(key, end, state.key));
    if (touching > 1) return false;
  }
  return true;
}

/// Nothing but its motion says anything of it: the next state may be tied to the one before, over both times.
bool Window::newest_is_mergeable(const Agent& agent) const {
  return options_.collapse && agent.states.size() > 1 && agent.states.back().motion.number >= 0 && is_empty(agent.states.back());
}

void Window::remove_newest(Agent& agent) {
  graph_.remove(agent.states.back().motion);
  gone_.assign(1, agent.states.back().key);
  values_.erase(gone_);
  agent.states.pop_back();
}

void Window::remove_landmark(Key key) {
  require_no_agent(key);
  values_.slot(key);
  leave(key);
  values_.erase(key);
}

}  // namespace holdfast
