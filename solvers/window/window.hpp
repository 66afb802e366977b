// A sliding window: a fixed-lag smoother over any variables and factors, on any back-end, by name or as an object.
//
//   WindowOptions options;
//   options.lag = 5;                                                             // [s]
//   Window window(options);
//   window.add_agent('A', WhiteAcceleration<Motion2>::exact(0.1, 1, R), 0.1);    // how A moves in one step of 0.1 s
//   window.add_state(A(0), t0, Motion2(…));                                      // its first state
//   window.add(Prior<Motion2>::from_sigmas(…), {A(0)});
//   window.add_landmark(L(0), Point2(3, 4));
//   while (…) {
//     window.add(Range<Motion2, Point2>{12.3, 0.5}, {window.at('A', t), L(0)}, Huber{2});   // t: when it was measured
//     const WindowStep& step = window.step(now);
//     … window.newest<Motion2>('A') …
//   }
//
// Agents without a motion model bring their odometry along: add_state(A(8), t, A(7), Between<Pose2>{…}).
//
// Time. Measurements come in any order. at(agent, t) is the agent's state at t, made where there is none: tied by the motion to the state
// before it and, if it is late, to the one after it, whose own motion from before is split. Times as old as the lag are refused by name
// (BadTime), and the window goes on as if they had not come. A state leaves when the NEXT one of its agent is as old as the lag: so any
// time inside the lag has a place, and the newest state of a silent agent stays until the agent comes back or is removed.
// Missing data. An agent's newest state that nothing but its motion ties is replaced, when the next one comes, by one motion factor over
// both: m steps without a measurement are one exact factor, F::merged(m), and no state.
// What leaves is marginalised (solvers/window/marginalize.hpp), robust terms at their current weights, or dropped. What marginalisation
// left, the arrival cost, can be truncated (arrival_limit), and an agent can keep lock (solvers/window/lock.hpp): notice that it follows
// outliers, say so, and start again from its latest measurements.
// Between states. state_at() has an agent's state at any time: the most likely one between two states, or the newest one moved on.
// Nothing is allocated in a steady state but what the back-end and the answers that were asked for (covariances, report) allocate.
#pragma once

#include <holdfast/solvers/backend.hpp>
#include <holdfast/solvers/detail/clock.hpp>
#include <holdfast/solvers/marginals.hpp>
#include <holdfast/solvers/outlier_report.hpp>
#include <holdfast/solvers/window/detail/lock.hpp>
#include <holdfast/solvers/window/detail/motion_model.hpp>
#include <holdfast/solvers/window/marginalize.hpp>

namespace holdfast {

namespace io {
class ByteWriter;
class ByteReader;
}  // namespace io

struct WindowOptions {
  enum class Leaving { marginalize, drop };

  double lag = std::numeric_limits<double>::infinity();  ///< > 0 [s]
  int max_states = 0;                                    ///< >= 0: that stay of each agent after a step; 0: no limit
  Leaving leaving = Leaving::marginalize;
  /// > 0 [sigmas]: an arrival cost ½‖r‖² with ‖r‖ beyond it at the answer is let go, and the rest solved again: truncated squares.
  double arrival_limit = std::numeric_limits<double>::infinity();
  bool collapse = true;          ///< of m empty steps one motion factor; false: keep a state for each
  std::string backend = "irls";  ///< backend_names(); not looked at where the window is given a back-end object
  Options solver;                ///< the same: the object brings its own options
  bool covariances = false;      ///< WindowStep::marginals
  bool report = false;           ///< WindowStep::report
  double deadline = std::numeric_limits<double>::infinity();  ///< > 0 [s] of a step: the solve is cut short to keep it
  double max_gap = std::numeric_limits<double>::infinity();   ///< > 0 [s]: a time stamp this far ahead of the newest is refused
  std::function<void(Key key, double time)> on_leaving;       ///< called before a state leaves, its last estimate still in values()

  /// Throws BadOption with field, value and rule.
  void validate() const;
};

struct WindowStep {
  double time = 0;                        ///< [s] now
  Summary summary;                        ///< of the solve
  std::vector<Key> left;                  ///< the states that left
  std::vector<Agent> lost;                ///< agents that keep lock, and whose inliers no longer explain their measurements
  std::vector<Agent> reacquired;          ///< those among them that go on from somewhere else
  int arrivals_let_go = 0;                ///< arrival costs beyond arrival_limit
  std::vector<std::string> removed;       ///< factors whose residual was not finite: taken out, in words, and the rest solved
  std::optional<Marginals> marginals;     ///< at the answer, before anything left; if asked for. None where H is not finite
  std::vector<MeasurementReport> report;  ///< the same
  struct Seconds {
    double add = 0;  ///< all add…() and at() since the last step
    double solve = 0, covariances = 0, report = 0, marginalize = 0;
    double total() const { return add + solve + covariances + report + marginalize; }
  } seconds;
  bool deadline_kept = true;  ///< total() <= options.deadline
};

class Window {
 public:
  explicit Window(WindowOptions options = {});
  /// On any back-end object, with the options it has: gnc(make_backend("irls")) graduates a redescending loss at every step. Throws
  /// BadOption for none.
  Window(WindowOptions options, std::unique_ptr<Backend> backend);
  Window(Window&&) noexcept;
  Window& operator=(Window&&) noexcept;
  ~Window();

  // ---- agents come and go: 'A', or Agent('r', 1234). Throws BadKey where the agent is there already, or is not there.

  /// Its motion: a factor for one step of dt [s], with merged(m) for m steps; or make(seconds), a factor for any time; or
  /// make(seconds, const State* from), one that depends on the state it leads from as it is estimated when the next one is made (noise that
  /// grows with the speed), null where nothing is known of it (solvers/window/lock.hpp).
  template <class F>
  void add_agent(Agent agent, const F& one_step, double dt, const Loss& loss = {}) {
    enter_agent(agent, std::make_unique<SteppedMotion<F>>(one_step, dt, loss));
  }
  template <class Make>
  void add_agent(Agent agent, Make make, const Loss& loss = {}) {
    enter_agent(agent, std::make_unique<TimedMotion<Make>>(std::move(make), loss));
  }
  /// It keeps lock (solvers/window/lock.hpp). nothing_known(seen): what is known of a state before any measurement, given where it is seen:
  /// a factor on that state. Call it before the agent has a state. Its first state may then be made by at(), too: it is put where its
  /// measurements are. Throws BadOption for an agent without a motion model, or with states.
  template <class NothingKnown>
  void keep_lock(Agent agent, const LockOptions& options, NothingKnown nothing_known) {
    using V = typename detail::UnaryFactor<NothingKnown>::Variable;
    enter_lock(agent, options, typeid(V), [nothing_known](Graph& graph, const Values& values, Key state) {
      return graph.add(nothing_known(values.at<V>(state)), {state}, Loss{}, 1.0);
    });
  }
  /// All its states leave now.
  void remove_agent(Agent agent);
  bool has_agent(Agent agent) const { return find(agent) != nullptr; }

  // ---- states and landmarks. Throws BadTime, BadKey.

  /// A state with a start value: the first of an agent, or one of an agent without a motion model.
  template <class V>
  void add_state(Key key, double time, const V& start) {
    const Lap lap(*this);
    require_new_state(key, time);
    values_.insert(key, start);
    enter_new(key, time);
  }
  /// A state that odometry leads to: its start is where the factor on {from, key} points.
  template <class F>
  void add_state(Key key, double time, Key from, const F& odometry, const Loss& loss = {}) {
    const Lap lap(*this);
    using V = typename F::Variables::template type<0>;
    require_new_state(key, time);
    const V start = predict(odometry, values_.at<V>(from));
    const FactorId id = graph_.add(odometry, {from, key}, loss);
    values_.insert(key, start);
    enter_new(key, time, id);
  }
  /// The agent's state at this time; made, if there is none, from its motion.
  Key at(Agent agent, double time);
  /// A variable without a time: it stays until it is removed.
  template <class V>
  void add_landmark(Key key, const V& start) {
    require_no_agent(key);
    values_.insert(key, start);
  }
  /// A landmark that is known: a constant.
  template <class V>
  void add_beacon(Key key, const V& known) {
    add_landmark(key, known);
    graph_.fix(key);
  }
  void remove_landmark(Key key);

  // ---- measurements: as Graph::add. Throws BadKey for a key that is not (or no longer) in the window, BadType, BadNumber.

  template <class F, class... LossAndWeight>
  FactorId add(const F& factor, const Graph::Keys<F>& keys, const LossAndWeight&... loss_and_weight) {
    const Lap lap(*this);
    require_variables<F>(keys, std::make_index_sequence<F::Variables::size>{});
    const FactorId id = graph_.add(factor, keys, loss_and_weight...);
    remember(keys.data(), keys.size(), id, [&](Graph& memory) { return memory.add(factor, keys, loss_and_weight...); });
    return id;
  }
  /// A copy of a factor of another graph, whatever it is, with its loss and weight (Graph::add_from).
  FactorId add_from(const Graph& other, FactorId id);
  void remove(FactorId id);

  // ---- one step: solve, answer, let the oldest leave.

  /// now [s]: not before the newest state, else that one's time counts. What is returned lives until the next step. Throws BadTime.
  const WindowStep& step(double now);

  // ---- what is known.

  const Graph& graph() const { return graph_; }
  const Values& values() const { return values_; }
  template <class V>
  const V& state(Key key) const {
    return values_.at<V>(key);
  }
  template <class V>
  const V& newest(Agent agent) const {
    return values_.at<V>(newest_key(agent));
  }
  Key newest_key(Agent agent) const;
  /// The agent's state at any time from its first state on [s]: that of then, the most likely one between two, or the newest one moved on.
  /// Asks the motion model, so from one thread at a time. Throws BadKey, BadType, BadTime.
  template <class V>
  V state_at(Agent agent, double time) const {
    V state;
    read_state(agent, time, typeid(V), &state);
    return state;
  }
  /// Its covariance, given which measurements are believed: of a state, or of the newest one moved on; of a time between two states throws
  /// BadTime. Throws UnobservableError, too.
  template <class V>
  Matrix<V::dim, V::dim> covariance_at(Agent agent, double time) const {
    Matrix<V::dim, V::dim> P;
    read_covariance(agent, time, typeid(V), P.data());
    return P;
  }
  double time(Key key) const;                     ///< of a state [s]; throws BadKey
  double newest_time() const { return newest_; }  ///< of all states [s]; −∞ before the first
  std::vector<Key> states(Agent agent) const;     ///< oldest first
  std::vector<Agent> agents() const;              ///< in the order in which they came
  const WindowStep& last_step() const { return step_; }
  const WindowOptions& options() const { return options_; }

  // ---- a robot that loses power resumes where it was.

  /// The whole window, what its agents that keep lock remember, and a note of yours into a versioned, checksummed file, written whole or
  /// not at all. Throws BadFile.
  void save(const std::string& path, std::string_view note = {}) const;
  /// Into a window with the same options, motion models and keep_lock(), whose states it replaces; returns the note. What follows has the
  /// same bits as if nothing had happened, and FactorIds of before name their factors again. An agent with a motion model that joined
  /// after the save stays, without states. Throws BadFile where the file is torn, foreign, of another version, or holds an agent that
  /// moves otherwise or keeps lock otherwise, or a type that this program does not have; the window is then as it was.
  std::string restore(const std::string& path);

 private:
  struct State {
    Key key;
    double time;
    FactorId motion;  ///< from the state before; number −1: none
  };
  struct Member {
    Agent agent;
    std::unique_ptr<MotionModel> motion;  ///< null: it brings its odometry
    std::vector<State> states;            ///< by time
    std::uint64_t next_step = 0;
    std::unique_ptr<detail::Lock> lock = nullptr;  ///< null: it keeps none

    bool is_known() const { return !lock || lock->is_settled(); }
  };
  /// Counts the time until the end of the scope as `add`.
  class Lap {
   public:
    explicit Lap(Window& window) : window_(window) {}
    ~Lap() { window_.seconds_add_ += watch_.seconds(); }
    Lap(const Lap&) = delete;
    Lap& operator=(const Lap&) = delete;

   private:
    Window& window_;
    Stopwatch watch_;
  };

  void enter_agent(Agent agent, std::unique_ptr<MotionModel> motion);
  const Member* find(Agent agent) const;
  Member* find(Agent agent) { return const_cast<Member*>(static_cast<const Window*>(this)->find(agent)); }
  const Member& known(Agent agent) const;
  void enter_lock(Agent agent, const LockOptions& options, std::type_index variable, detail::Lock::NothingKnown nothing_known);
  /// Enters a new measurement where an agent keeps lock; copy(memory) adds it there.
  template <class Copy>
  void remember(const Key* keys, std::size_t count, FactorId id, const Copy& copy) {
    for (Member& member : members_) {
      if (!member.lock) continue;
      const Key* const mine = std::find_if(keys, keys + count, [&](Key key) { return key.agent() == member.agent; });
      if (mine == keys + count) continue;
      const bool alone = std::all_of(keys, keys + count, [&](Key key) { return key.agent() == member.agent || !has_agent(key.agent()); });
      member.lock->measured.push_back({*mine, id, alone ? copy(member.lock->memory) : FactorId{}});
    }
  }
  void require_time(double time) const;
  void require_no_agent(Key key) const;
  template <class F, std::size_t... I>
  void require_variables(const Graph::Keys<F>& keys, std::index_sequence<I...>) const {
    using Vars = typename F::Variables;
    for (std::size_t i = 0; i < keys.size(); ++i)
      if (!values_.contains(keys[i])) fail_unknown(keys[i], factor_name<F>());
    (values_.at<typename Vars::template type<I>>(keys[I]), ...);
  }
  [[noreturn]] void fail_unknown(Key key, const std::string& factor) const;
  void require_new_state(Key key, double time) const;
  void enter_new(Key key, double time, FactorId odometry = {});
  /// Where among its agent's states a new one comes, and its motion from the state before and to the one after.
  struct Place {
    std::size_t index = 0;
    FactorId motion, onward;
  };
  Place tie(Member& member, Key key, double time, int passed_over = 0);
  void enter(Member& member, const State& state, const Place& place);
  Key make_first(Member& member, double time);
  bool is_empty(const State& state) const;
  bool newest_is_mergeable(const Member& member) const;
  void remove_newest(Member& member);

  const State* state_before(const Member& member, double time) const;
  const double* coordinates(Key key, std::type_index type) const;
  void read_state(Agent agent, double time, std::type_index type, void* state) const;
  void read_covariance(Agent agent, double time, std::type_index type, double* covariance) const;

  void solve();
  void solve_again();
  bool remove_non_finite();
  void let_arrivals_go();
  // solvers/window/lock.hpp
  void place_first(Member& member);
  void watch(Member& member);
  void try_again(const detail::Lock::Measured& measured);
  bool is_rejected(const Member& member, FactorId id) const;
  bool explains_the_data(const Member& member) const;
  std::vector<State> remembered(const Member& member) const;
  Graph from_nothing(const Member& member, const std::vector<State>& states, Values& values, bool known) const;
  bool acquire(Member& member);
  void go_on_from(Member& member, const std::vector<State>& states, Values& found);
  void forget_arrivals(const Member& member);
  void let_leave();
  void leave(Key key);
  std::unordered_map<Key, double> times() const;
  void write(io::ByteWriter& out, const Member& member) const;
  Member read_member(io::ByteReader& in, const Graph& graph, const Values& values) const;

  WindowOptions options_;
  std::unique_ptr<Backend> backend_;
  Graph graph_;
  Values values_;
  std::vector<Member> members_;
  double newest_ = -std::numeric_limits<double>::infinity();
  double seconds_add_ = 0;
  WindowStep step_;
  Marginalizer marginalizer_;
  std::vector<Key> gone_;
  Values saved_;
};

}  // namespace holdfast
