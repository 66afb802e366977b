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

const Window::Member* Window::find(Agent agent) const {
  for (const Member& member : members_)
    if (member.agent == agent) return &member;
  return nullptr;
}

const Window::Member& Window::known(Agent agent) const {
  const Member* member = find(agent);
  if (member == nullptr) fail<BadKey>("there is no agent ", agent, " in the window; add_agent() or add_state() first");
  return *member;
}

void Window::enter_agent(Agent agent, std::unique_ptr<MotionModel> motion) {
  require_no_agent(agent(0));
  for (Key key : values_.keys())
    if (key.agent() == agent) fail<BadKey>("agent ", agent, ": there is a landmark ", key, " of this agent; choose another one");
  members_.push_back({agent, std::move(motion), {}, 0, nullptr});
}

void Window::remove_agent(Agent agent) {
  known(agent);
  gone_.clear();
  for (const State& state : find(agent)->states) {
    if (options_.on_leaving) options_.on_leaving(state.key, state.time);
    leave(state.key);
    gone_.push_back(state.key);
  }
  values_.erase(gone_);
  members_.erase(members_.begin() + (find(agent) - members_.data()));
}

Key Window::newest_key(Agent agent) const {
  const Member& member = known(agent);
  if (member.states.empty()) fail<BadKey>("agent ", agent, " has no state yet; add_state() its first one");
  return member.states.back().key;
}

double Window::time(Key key) const {
  const Member* member = find(key.agent());
  if (member != nullptr)
    for (const State& state : member->states)
      if (state.key == key) return state.time;
  fail<BadKey>("key ", key, " is no state of the window (any more)");
}

std::vector<Key> Window::states(Agent agent) const {
  std::vector<Key> keys;
  for (const State& state : known(agent).states) keys.push_back(state.key);
  return keys;
}

std::vector<Agent> Window::agents() const {
  std::vector<Agent> all;
  for (const Member& member : members_) all.push_back(member.agent);
  return all;
}

std::unordered_map<Key, double> Window::times() const {
  std::unordered_map<Key, double> all;
  for (const Member& member : members_)
    for (const State& state : member.states) all.emplace(state.key, state.time);
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
    fail<BadKey>("key ", key, ": there is an agent ", key.agent(), " in the window; choose another kind or number");
}

void Window::fail_unknown(Key key, const std::string& factor) const {
  fail<BadKey>("factor ", factor, ": key ", key,
               " is not in the window: it was never added, has left, or was an empty state merged into one motion; ask at(agent, time)");
}

FactorId Window::add_from(const Graph& other, FactorId id) {
  const Lap lap(*this);
  const Graph::Place& place = other.place(id);
  const FactorBatch& batch = *other.batches()[place.batch];
  const Key* const keys = batch.keys(place.index);
  for (int k = 0; k < batch.arity(); ++k) {
    if (!values_.contains(keys[k])) fail_unknown(keys[k], batch.name());
    const PoolBase& pool = values_.pool(values_.slot(keys[k]).pool);
    if (pool.type() != batch.types()[k])
      fail<BadType>("factor ", batch.describe(place.index), ": key ", keys[k], " is a ", pool.type_name(),
                    " in the window, but the factor needs a ", batch.type_names()[k]);
  }
  const FactorId mine = graph_.add_from(other, id);
  remember(keys, batch.dims().size(), mine, [&](Graph& memory) { return memory.add_from(other, id); });
  return mine;
}

// Checks first, so that a refused state leaves no trace.
void Window::require_new_state(Key key, double time) const {
  require_time(time);
  if (values_.contains(key)) fail<BadKey>("key ", key, " is in the window already; each state has its own step");
  if (const Member* member = find(key.agent())) {
    for (const State& state : member->states)
      if (same_time(state.time, time))
        fail<BadTime>("key ", key, ": agent ", key.agent(), " has a state at ", time, " s already, ", state.key, "; measure that one");
    return;
  }
  for (Key other : values_.keys())
    if (other.agent() == key.agent()) fail<BadKey>("key ", key, ": there is a landmark ", other, " of this agent; choose another one");
}

// Its value, and the odometry that leads to it, are there already.
void Window::enter_new(Key key, double time, FactorId odometry) {
  if (!has_agent(key.agent())) members_.push_back({key.agent(), nullptr, {}, 0, nullptr});
  Member& member = *find(key.agent());
  try {
    const Place place = tie(member, key, time);
    enter(member, {key, time, place.motion}, place);
  } catch (...) {
    if (odometry.number >= 0) graph_.remove(odometry);
    values_.erase(key);
    throw;
  }
}

// The new state has a value. The motion factors may refuse the times or their own numbers, and then the graph has not changed.
// passed_over: states before the new one that its motion leads over.
Window::Place Window::tie(Member& member, Key key, double time, int passed_over) {
  const auto after = std::find_if(member.states.begin(), member.states.end(), [&](const State& s) { return s.time > time; });
  Place place{static_cast<std::size_t>(after - member.states.begin()), {}, {}};
  if (!member.motion) return place;
  if (after != member.states.begin()) {
    const State& before = *(after - 1 - passed_over);
    place.motion = member.motion->add(graph_, values_, before.key, key, time - before.time, member.is_known());
  }
  if (after == member.states.end()) return place;
  try {
    place.onward = member.motion->add(graph_, values_, key, after->key, after->time - time, member.is_known());
  } catch (...) {
    if (place.motion.number >= 0) graph_.remove(place.motion);
    throw;
  }
  if (after->motion.number >= 0) graph_.remove(after->motion);  // it passed over the new state: split
  return place;
}

void Window::enter(Member& member, const State& state, const Place& place) {
  member.states.insert(member.states.begin() + static_cast<std::ptrdiff_t>(place.index), state);
  if (place.onward.number >= 0) member.states[place.index + 1].motion = place.onward;
  member.next_step = std::max(member.next_step, std::uint64_t{state.key.step()} + 1);
  if (member.lock) ++member.lock->states;
  newest_ = std::max(newest_, state.time);
}

Key Window::at(Agent agent, double time) {
  const Lap lap(*this);
  known(agent);
  Member& member = *find(agent);
  require_time(time);
  for (auto state = member.states.rbegin(); state != member.states.rend() && state->time > time - 1; ++state)
    if (same_time(state->time, time)) return state->key;
  if (member.lock && member.states.empty()) return make_first(member, time);
  if (member.states.empty() || time < member.states.front().time)
    fail<BadTime>("agent ", agent, " at ", time, " s: ", member.states.empty() ? "it has no state yet" : "its first state is later",
                  "; add_state() tells where it starts");
  if (!member.motion)
    fail<BadTime>("agent ", agent, " has no state at ", time,
                  " s and no motion to make one from; add_agent() with a motion, or add_state() with odometry");
  const auto after = std::find_if(member.states.begin(), member.states.end(), [time](const State& s) { return s.time > time; });
  const bool merges = after == member.states.end() && newest_is_mergeable(member);
  const State& before = *(after - (merges ? 2 : 1));
  const Key key = agent(member.next_step);
  member.motion->insert_predicted(values_, before.key, key, time - before.time, member.is_known());
  Place place;
  try {
    place = tie(member, key, time, merges ? 1 : 0);
  } catch (...) {
    values_.erase(key);
    throw;
  }
  if (merges) {
    remove_newest(member);
    --place.index;
  }
  enter(member, {key, time, place.motion}, place);
  return key;
}

// Of an agent that keeps lock: where it is, its measurements say (place_first).
Key Window::make_first(Member& member, double time) {
  const Key key = member.agent(member.next_step);
  member.motion->insert_unknown(values_, key);
  enter(member, {key, time, {}}, {});
  member.lock->is_unplaced = true;
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
bool Window::newest_is_mergeable(const Member& member) const {
  return options_.collapse && member.states.size() > 1 && member.states.back().motion.number >= 0 && is_empty(member.states.back());
}

void Window::remove_newest(Member& member) {
  graph_.remove(member.states.back().motion);
  gone_.assign(1, member.states.back().key);
  values_.erase(gone_);
  member.states.pop_back();
  if (member.lock) --member.lock->states;
}

void Window::remove(FactorId id) {
  graph_.remove(id);
  for (const Member& member : members_)
    if (member.lock) member.lock->forget(id);
}

void Window::remove_landmark(Key key) {
  require_no_agent(key);
  values_.slot(key);
  leave(key);
  for (const Member& member : members_)
    if (member.lock) member.lock->forget(key);
  values_.erase(key);
}

// ---- between states

/// The latest one that is not later; null: there is none.
const Window::State* Window::state_before(const Member& member, double time) const {
  const State* latest = nullptr;
  for (const State& state : member.states)
    if (state.time <= time || same_time(state.time, time)) latest = &state;
  return latest;
}

const double* Window::coordinates(Key key, std::type_index type) const {
  const Values::Slot& slot = values_.slot(key);
  const PoolBase& pool = values_.pool(slot.pool);
  if (pool.type() != type) fail<BadType>("key ", key, " is a ", pool.type_name(), ", and was asked for as another type");
  return pool.data(slot.index);
}

void Window::read_state(Agent agent, double time, std::type_index type, void* state) const {
  const Member& member = known(agent);
  const State* const before = state_before(member, time);
  if (before == nullptr) fail<BadTime>("agent ", agent, " at ", time, " s: its first state in the window is later, or there is none");
  const double* const from = coordinates(before->key, type);
  const double seconds = time - before->time;
  if (same_time(before->time, time)) {
    const PoolBase& pool = values_.pool(values_.slot(before->key).pool);
    std::copy_n(from, pool.ambient(), static_cast<double*>(state));
    return;
  }
  if (!member.motion)
    fail<BadTime>("agent ", agent, " has no state at ", time, " s and no motion to tell one from; ask at one of its states");
  if (before == &member.states.back()) return member.motion->predicted(from, seconds, state);
  const State& after = before[1];
  member.motion->between(from, coordinates(after.key, type), seconds, after.time - time, state);
}

void Window::read_covariance(Agent agent, double time, std::type_index type, double* covariance) const {
  const Member& member = known(agent);
  const State* const before = state_before(member, time);
  const bool is_state = before != nullptr && same_time(before->time, time);
  if (before == nullptr || (!is_state && (before != &member.states.back() || !member.motion)))
    fail<BadTime>("agent ", agent, " at ", time, " s: a covariance is known at its states, and after the newest one");
  const double* const from = coordinates(before->key, type);
  const std::vector<double> P = Marginals(graph_, values_).covariance(before->key);
  std::copy(P.begin(), P.end(), covariance);
  if (!is_state) member.motion->carry(from, time - before->time, covariance);
}

}  // namespace holdfast
