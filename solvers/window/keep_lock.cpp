// Window: an agent that keeps lock (solvers/window/lock.hpp).
#include <algorithm>
#include <holdfast/solvers/gnc.hpp>
#include <holdfast/solvers/window/window.hpp>

namespace holdfast {
namespace {

constexpr double kCheaper = 1e-6;  // part of the cost by which a re-acquisition must be cheaper: less is rounding

/// Another back-end as an inner one, for as long as that one lives.
class Borrowed final : public Backend {
 public:
  explicit Borrowed(Backend& lender) : Backend(lender.options), lender_(lender) {}
  std::string name() const override { return lender_.name(); }

 protected:
  Summary minimize(const Graph& graph, Values& values) override {
    const Options own = std::exchange(lender_.options, options);
    Summary summary = lender_.solve(graph, values);
    lender_.options = own;
    return summary;
  }

 private:
  Backend& lender_;
};

const Loss& loss_of(const Graph& graph, FactorId id) {
  const Graph::Place& place = graph.place(id);
  return graph.batches()[place.batch]->loss(place.index);
}

void truncate_robust_losses(Graph& graph, double threshold) {
  for (std::size_t b = 0; b < graph.batches().size(); ++b)
    if (!(graph.batches()[b]->family() == Loss{})) graph.set_loss(static_cast<int>(b), TruncatedSquares{threshold});
}

/// The variables of a graph that are not of this agent.
std::vector<Key> others(const Graph& graph, Agent agent) {
  std::vector<Key> keys;
  for (const auto& batch : graph.batches())
    for (int i = 0; i < batch->size(); ++i)
      for (int k = 0; k < batch->arity(); ++k)
        if (const Key key = batch->keys(i)[k]; key.agent() != agent) keys.push_back(key);
  return keys;
}

}  // namespace

void Window::enter_lock(Agent agent, const LockOptions& options, std::type_index variable, detail::Lock::NothingKnown nothing_known) {
  known(agent);
  Member& member = *find(agent);
  if (!member.motion) fail<BadOption>("keep_lock(): agent ", agent, " has no motion model; add_agent() with a motion first");
  if (variable != member.motion->state())
    fail<BadType>("keep_lock(): what is known of a state of agent ", agent, " is a factor on another type of variable");
  if (!member.states.empty()) fail<BadOption>("keep_lock(): agent ", agent, " has states already; call it before the first");
  member.lock = std::make_unique<detail::Lock>(options, std::move(nothing_known));
}

// Put where it is seen: there is no other word on where it starts.
void Window::place_first(Member& member) {
  detail::Lock& lock = *member.lock;
  const Key first = member.states.front().key;
  if (lock.is_unplaced)
    for (const auto& one : lock.measured)
      if (one.state == first) detail::move_to_measurement(graph_, values_, one.id, first);
  lock.is_new = lock.is_unplaced = false;
  lock.prior = lock.nothing_known(graph_, values_, first);
}

bool Window::is_rejected(const Member& member, FactorId id) const {
  return detail::residual_norm(graph_, values_, id) > member.lock->options.rejected;
}

// After a solve.
void Window::watch(Member& member) {
  detail::Lock& lock = *member.lock;
  for (; lock.fresh < lock.measured.size(); ++lock.fresh) {
    const auto& one = lock.measured[lock.fresh];
    if (!graph_.contains(one.id)) continue;
    if (!loss_of(graph_, one.id).is_convex() && is_rejected(member, one.id)) try_again(one);
  }
  if (explains_the_data(member)) return;
  step_.lost.push_back(member.agent);
  if (lock.states < lock.next_acquisition) return;
  const bool was_settled = lock.is_settled();
  if (acquire(member) && was_settled) step_.reacquired.push_back(member.agent);
}

// Far from its prediction a measurement starts with no weight, and would keep none: the start where it is right gets its chance, too.
void Window::try_again(const detail::Lock::Measured& measured) {
  saved_ = values_;
  const Summary before = step_.summary;
  const double cost = graph_.cost(values_);
  detail::move_to_measurement(graph_, values_, measured.id, measured.state);
  solve_again();
  if (step_.summary.usable() && graph_.cost(values_) < cost) return;
  values_.assign(saved_);
  step_.summary = before;
}

bool Window::explains_the_data(const Member& member) const {
  const detail::Lock& lock = *member.lock;
  int counted = 0, rejected = 0;
  for (auto one = lock.measured.rbegin(); one != lock.measured.rend() && counted < lock.options.recent; ++one) {
    if (!graph_.contains(one->id) || loss_of(graph_, one->id) == Loss{}) continue;
    ++counted;
    rejected += is_rejected(member, one->id);
  }
  return 2 * rejected <= counted;
}

/// The states in memory, oldest first, those that have left the window before those that are in it.
std::vector<Window::State> Window::remembered(const Member& member) const {
  std::vector<State> states;
  for (const auto& left : member.lock->left) states.push_back({left.key, left.time, {}});
  states.insert(states.end(), member.states.begin(), member.states.end());
  return states;
}

/// The measurements in memory, the motion between their states, and nothing else that is known; landmarks as they are believed, fixed.
Graph Window::from_nothing(const Member& member, const std::vector<State>& states, Values& values, bool known) const {
  Graph graph = member.lock->memory;
  for (const Key key : others(graph, member.agent)) {
    detail::copy_variable(key, values_, values);
    graph.fix(key);
  }
  member.lock->nothing_known(graph, values, states.front().key);
  for (std::size_t i = 1; i < states.size(); ++i)
    member.motion->add(graph, values, states[i - 1].key, states[i].key, states[i].time - states[i - 1].time, known);
  return graph;
}

// From nothing and from what was believed, under the same costs; true where the first is cheaper, and the window goes on from it.
bool Window::acquire(Member& member) {
  detail::Lock& lock = *member.lock;
  lock.next_acquisition = lock.states + lock.options.patience;
  const std::vector<State> states = remembered(member);
  Values found, believed;
  for (std::size_t i = 0; i < states.size(); ++i) {
    const Key key = states[i].key;
    member.motion->insert_unknown(found, key);
    detail::copy_variable(key, i < lock.left.size() ? lock.values : values_, believed);
  }
  for (const Key key : others(lock.memory, member.agent)) detail::copy_variable(key, values_, found);
  for (const auto& one : lock.measured)
    if (lock.memory.contains(one.copy) && found.contains(one.state)) detail::move_to_measurement(lock.memory, found, one.copy, one.state);
  Graph graph = from_nothing(member, states, found, false);
  for (const Key key : graph.fixed()) detail::copy_variable(key, found, believed);
  truncate_robust_losses(graph, lock.options.rejected);
  const auto graduated = gnc(std::make_unique<Borrowed>(*backend_));
  graduated->solve(graph, found);
  Borrowed(*backend_).solve(graph, found);
  Borrowed(*backend_).solve(graph, believed);
  if (!(graph.cost(found) < graph.cost(believed) * (1 - kCheaper))) return false;
  go_on_from(member, states, found);
  return true;
}

// The states that have left the window leave this problem, too: what they say of the first one that stays is the new arrival cost.
void Window::go_on_from(Member& member, const std::vector<State>& states, Values& found) {
  detail::Lock& lock = *member.lock;
  Graph graph = from_nothing(member, states, found, member.is_known());
  Borrowed(*backend_).solve(graph, found);
  forget_arrivals(member);
  for (State& state : member.states)
    if (state.motion.number >= 0) graph_.remove(std::exchange(state.motion, FactorId{}));
  for (std::size_t i = 1; i < member.states.size(); ++i) {
    const State &from = member.states[i - 1], &to = member.states[i];
    member.states[i].motion = member.motion->add(graph_, found, from.key, to.key, to.time - from.time, member.is_known());
  }
  for (const State& state : member.states) detail::copy_variable(state.key, found, values_);
  FactorId arrival;
  for (const auto& left : lock.left) {
    detail::copy_variable(left.key, found, lock.values);
    arrival = marginalizer_.eliminate(graph, found, left.key);
  }
  if (lock.left.empty())
    lock.prior = lock.nothing_known(graph_, values_, member.states.front().key);
  else if (arrival.number >= 0)
    graph_.add(std::as_const(graph).at<LinearPrior>(arrival));
  solve_again();
}

// Without what is known of this agent from before the window. What that says of others stays.
void Window::forget_arrivals(const Member& member) {
  if (graph_.contains(member.lock->prior)) graph_.remove(member.lock->prior);
  const auto is_mine = [&](Key key) { return key.agent() == member.agent; };
  std::vector<FactorId> arrivals;
  for (std::size_t b = 0; b < graph_.batches().size(); ++b) {
    const FactorBatch& batch = *graph_.batches()[b];
    if (batch.factor_type() == typeid(LinearPrior) && batch.size() > 0 &&
        std::any_of(batch.keys(0), batch.keys(0) + batch.arity(), is_mine))
      arrivals.push_back(graph_.id_of(static_cast<int>(b), 0));
  }
  for (const FactorId id : arrivals) {
    const LinearPrior arrival = std::as_const(graph_).at<LinearPrior>(id);
    graph_.remove(id);
    Graph alone;
    FactorId rest = alone.add(arrival);
    for (const Key key : arrival.keys)
      if (is_mine(key) && rest.number >= 0) rest = marginalizer_.eliminate(alone, values_, key);
    if (rest.number >= 0) graph_.add(std::as_const(alone).at<LinearPrior>(rest));
  }
}

}  // namespace holdfast
