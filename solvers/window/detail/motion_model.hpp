// How an agent of a Window moves when nothing is measured: a motion factor for any time between two of its states.
#pragma once

#include <holdfast/graph/graph.hpp>
#include <optional>

namespace holdfast {

/// A time stamp that cannot be: not finite, outside the lag, off an agent's grid, too far ahead.
class BadTime : public Error {
 public:
  using Error::Error;
};

/// The state at which the motion factor from `from` has no residual: Newton on r(from, ·) = 0, one step where the factor is linear.
template <class F, class V>
V predict(const F& motion, const V& from) {
  static_assert(F::residual_dim == V::dim, "a motion factor has as many rows as its state: then it says where the state goes");
  constexpr int kSteps = is_linear<F> ? 1 : 20;
  V next = from;
  for (int i = 0; i < kSteps; ++i) {
    Jacobians<F> J;
    const Vector<V::dim> r = motion(from, next, &J);
    const Matrix<V::dim, V::dim> W = J.template wrt<1>();
    Vector<V::dim> delta;
    detail::solve_square(V::dim, W.data(), r.data(), delta.data());
    next = next.retract(-delta);
    if (!(delta.norm() > 1e-13 * (1 + V{}.local(next).norm()))) break;
  }
  return next;
}

/// The most likely state between two others: the least of ½‖r(from, ·)‖² + ½‖r(·, to)‖² of the motions on either side of it.
template <class F, class V>
V state_between(const F& before, const F& after, const V& from, const V& to) {
  constexpr int kSteps = is_linear<F> ? 1 : 20;
  V state = predict(before, from);
  for (int i = 0; i < kSteps; ++i) {
    Jacobians<F> J_before, J_after;
    const Vector<V::dim> r_before = before(from, state, &J_before), r_after = after(state, to, &J_after);
    const Matrix<V::dim, V::dim> B = J_before.template wrt<1>(), A = J_after.template wrt<0>();
    const Matrix<V::dim, V::dim> H = B.transpose() * B + A.transpose() * A;
    const Vector<V::dim> g = B.transpose() * r_before + A.transpose() * r_after;
    Vector<V::dim> delta;
    detail::solve_square(V::dim, H.data(), g.data(), delta.data());
    state = state.retract(-delta);
    if (!(delta.norm() > 1e-13 * (1 + V{}.local(state).norm()))) break;
  }
  return state;
}

/// What the motion makes of a state's covariance P: J₁⁻¹ (J₀ P J₀ᵀ + I) J₁⁻ᵀ, its Jacobians where it has no residual.
template <class F, class V>
Matrix<V::dim, V::dim> carried_covariance(const F& motion, const V& from, const Matrix<V::dim, V::dim>& P) {
  using Square = Matrix<V::dim, V::dim>;
  Jacobians<F> J;
  motion(from, predict(motion, from), &J);
  const Square J0 = J.template wrt<0>(), J1 = J.template wrt<1>();
  const auto divided = [&J1](const Square& A) {
    Square X;
    for (int c = 0; c < V::dim; ++c) detail::solve_square(V::dim, J1.data(), A.data() + c * V::dim, X.data() + c * V::dim);
    return X;
  };
  const Square half = divided(J0 * P * J0.transpose() + Square::Identity());
  return divided(half.transpose());
}

/// What a Window knows of it. States and covariances go in and out as bare memory: of the agent's own type of state.
class MotionModel {
 public:
  virtual ~MotionModel() = default;
  virtual std::string name() const = 0;
  virtual std::type_index state() const = 0;
  /// known: whether the value of `from` is an estimate, so that the motion may depend on it.
  virtual FactorId add(Graph& graph, const Values& values, Key from, Key to, double seconds, bool known) = 0;
  virtual void insert_predicted(Values& values, Key from, Key to, double seconds, bool known) = 0;
  /// A state of which nothing is known: V{}.
  virtual void insert_unknown(Values& values, Key key) const = 0;
  virtual void predicted(const void* from, double seconds, void* state) = 0;
  virtual void between(const void* from, const void* to, double seconds_before, double seconds_after, void* state) = 0;
  virtual void carry(const void* from, double seconds, double* covariance) = 0;
};

/// Whatever makes a motion factor F for a time.
template <class F>
class FactorMotion : public MotionModel {
 public:
  using State = typename F::Variables::template type<0>;
  explicit FactorMotion(const Loss& loss) : loss_(loss) {}
  std::string name() const override { return detail::demangled(typeid(F)); }
  std::type_index state() const override { return typeid(State); }
  FactorId add(Graph& graph, const Values& values, Key from, Key to, double seconds, bool known) override {
    return graph.add(over(seconds, known ? &values.at<State>(from) : nullptr), {from, to}, loss_);
  }
  void insert_predicted(Values& values, Key from, Key to, double seconds, bool known) override {
    const State& start = values.at<State>(from);
    const State next = predict(over(seconds, known ? &start : nullptr), start);
    values.insert(to, next);
  }
  void insert_unknown(Values& values, Key key) const override { values.insert(key, State{}); }
  void predicted(const void* from, double seconds, void* state) override {
    const State& start = *static_cast<const State*>(from);
    *static_cast<State*>(state) = predict(over(seconds, &start), start);
  }
  void between(const void* from, const void* to, double seconds_before, double seconds_after, void* state) override {
    const State &a = *static_cast<const State*>(from), &b = *static_cast<const State*>(to);
    const F before = over(seconds_before, &a), after = over(seconds_after, &a);
    *static_cast<State*>(state) = state_between(before, after, a, b);
  }
  void carry(const void* from, double seconds, double* covariance) override {
    const State& start = *static_cast<const State*>(from);
    Eigen::Map<Matrix<State::dim, State::dim>> P(covariance);
    P = carried_covariance(over(seconds, &start), start, Matrix<State::dim, State::dim>(P));
  }

 protected:
  /// from: null where nothing is known of it. What is returned lives until the next call.
  virtual const F& over(double seconds, const State* from) = 0;

 private:
  Loss loss_;
};

/// Steps of dt [s]: one factor `step`, and step.merged(m) for m of them. Times are on the agent's grid.
template <class F>
class SteppedMotion final : public FactorMotion<F> {
 public:
  using State = typename FactorMotion<F>::State;
  SteppedMotion(const F& step, double dt, const Loss& loss) : FactorMotion<F>(loss), step_(step), dt_(dt) {
    if (!(std::isfinite(dt) && dt > 0)) fail<BadNumber>("the motion of an agent: dt = ", dt, " must be finite and > 0 [s]");
  }

 private:
  /// Made once for each number of steps.
  const F& over(double seconds, const State*) override {
    constexpr double kGrid = 1e-3;  // of dt
    const double steps = std::round(seconds / dt_);
    if (!(steps >= 1 && steps < 1e6 && std::abs(seconds / dt_ - steps) <= kGrid))
      fail<BadTime>(seconds, " s between two states is no multiple (from 1 to 1e6) of the motion's dt = ", dt_,
                    " s; put the time stamp on the agent's grid, or give add_agent() a motion for any time");
    const auto m = static_cast<std::size_t>(steps);
    if (m == 1) return step_;
    if (merged_.size() <= m && m <= kKept) merged_.resize(m + 1);
    std::optional<F>& factor = m <= kKept ? merged_[m] : longer_;
    if (!factor || m > kKept) factor = step_.merged(static_cast<int>(m));
    return *factor;
  }

  static constexpr std::size_t kKept = 256;
  F step_;
  double dt_;
  std::vector<std::optional<F>> merged_;  ///< by m
  std::optional<F> longer_;
};

namespace detail {
/// What a function, or an object with one operator(), returns.
template <class Fn>
struct Returned : Returned<decltype(&Fn::operator())> {};
template <class R, class... A>
struct Returned<R (*)(A...)> {
  using type = std::decay_t<R>;
};
template <class R, class C, class... A>
struct Returned<R (C::*)(A...) const> {
  using type = std::decay_t<R>;
};
/// fn(const V&), a factor on V.
template <class Fn>
struct UnaryFactor {
  using F = typename Returned<Fn>::type;
  static_assert(F::Variables::size == 1, "what is known of a state is a factor on this state alone");
  using Variable = typename F::Variables::template type<0>;
};
/// The factor that make(seconds) or make(seconds, from) returns.
template <class Make, bool = std::is_invocable_v<const Make&, double>>
struct MadeBy {
  using F = std::decay_t<std::invoke_result_t<const Make&, double>>;
};
template <class Make>
struct MadeBy<Make, false> {
  using F = typename Returned<Make>::type;
};
}  // namespace detail

/// make(seconds): the motion factor over any time. Or make(seconds, from): one that depends on the state it leads from, null where nothing
/// is known of that.
template <class Make>
class TimedMotion final : public FactorMotion<typename detail::MadeBy<Make>::F> {
 public:
  using F = typename detail::MadeBy<Make>::F;
  using State = typename FactorMotion<F>::State;
  TimedMotion(Make make, const Loss& loss) : FactorMotion<F>(loss), make_(std::move(make)) {}

 private:
  const F& over(double seconds, const State* from) override {
    if constexpr (std::is_invocable_v<const Make&, double>)
      return made_.emplace(make_(seconds));
    else
      return made_.emplace(make_(seconds, from));
  }

  Make make_;
  std::optional<F> made_;
};

}  // namespace holdfast
