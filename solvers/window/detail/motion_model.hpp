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

/// What a Window knows of it.
class MotionModel {
 public:
  virtual ~MotionModel() = default;
  virtual std::string name() const = 0;
  virtual FactorId add(Graph& graph, Key from, Key to, double seconds) = 0;
  virtual void insert_predicted(Values& values, Key from, Key to, double seconds) = 0;
};

/// Steps of dt [s]: one factor `step`, and step.merged(m) for m of them. Times are on the agent's grid.
template <class F>
class SteppedMotion final : public MotionModel {
 public:
  using State = typename F::Variables::template type<0>;
  SteppedMotion(const F& step, double dt, const Loss& loss) : step_(step), dt_(dt), loss_(loss) {
    if (!(std::isfinite(dt) && dt > 0)) fail<BadNumber>("the motion of an agent: dt = ", dt, " must be finite and > 0 [s]");
  }
  std::string name() const override { return detail::demangled(typeid(F)); }
  FactorId add(Graph& graph, Key from, Key to, double seconds) override { return graph.add(over(seconds), {from, to}, loss_); }
  void insert_predicted(Values& values, Key from, Key to, double seconds) override {
    const State next = predict(over(seconds), values.at<State>(from));
    values.insert(to, next);
  }

 private:
  /// Made once for each number of steps.
  const F& over(double seconds) {
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
  Loss loss_;
  std::vector<std::optional<F>> merged_;  ///< by m
  std::optional<F> longer_;
};

/// make(seconds): the motion factor over any time.
template <class Make>
class TimedMotion final : public MotionModel {
 public:
  using F = std::decay_t<decltype(std::declval<const Make&>()(1.0))>;
  using State = typename F::Variables::template type<0>;
  TimedMotion(Make make, const Loss& loss) : make_(std::move(make)), loss_(loss) {}
  std::string name() const override { return detail::demangled(typeid(F)); }
  FactorId add(Graph& graph, Key from, Key to, double seconds) override { return graph.add(make_(seconds), {from, to}, loss_); }
  void insert_predicted(Values& values, Key from, Key to, double seconds) override {
    const State next = predict(make_(seconds), values.at<State>(from));
    values.insert(to, next);
  }

 private:
  Make make_;
  Loss loss_;
};

}  // namespace holdfast
