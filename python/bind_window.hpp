// What a Window and a Schedule ask of a type of factors: a motion, the odometry that leads to a state, a stream of measurements.
#pragma once

#include <holdfast/factors/prior.hpp>

#include "bind_factor.hpp"

namespace holdfast::python {

/// A factor that a Python function returns. What it raises leaves whoever asked for the factor.
template <class F>
F returned_factor(const char* what, nb::handle given) {
  F* factor = nullptr;
  if (!nb::try_cast<F*>(given, factor) || factor == nullptr)
    throw nb::type_error((std::string(what) + " returns a " + factor_name<F>() + " on the variables it was announced for, not " +
                          nb::cast<std::string>(nb::repr(given)))
                             .c_str());
  if constexpr (detail::HasValidate<F>::value) factor->validate();
  return *factor;
}

/// motion(seconds, state): state is None where nothing is known of it.
template <class F>
struct PythonMotion {
  using State = typename F::Variables::template type<0>;
  std::shared_ptr<nb::object> function;
  F operator()(double seconds, const State* from) const {
    const nb::gil_scoped_acquire gil;
    const nb::object state = from == nullptr ? nb::none() : nb::cast(*from);
    return returned_factor<F>("motion(seconds, state)", (*function)(seconds, state));
  }
};

/// How an agent moves, by a factor F; and with merged(m), steps of one.
template <class F>
void bind_motion(nb::class_<F>& c) {
  c.def_static("_move_by", [](Window& window, nb::handle agent, nb::object motion, const Loss& loss) {
    require_unused(&window, "Window");
    window.add_agent(agent_of(agent), PythonMotion<F>{held(std::move(motion))}, loss);
  });
}
template <class F>
void bind_stepped_motion(nb::class_<F>& c) {
  bind_motion(c);
  c.def("_move_in_steps", [](const F& step, Window& window, nb::handle agent, double dt, const Loss& loss) {
    require_unused(&window, "Window");
    if constexpr (detail::HasValidate<F>::value) step.validate();
    window.add_agent(agent_of(agent), step, dt, loss);
  });
}

/// The state that odometry leads to.
template <class F>
void bind_odometry(nb::class_<F>& c) {
  c.def("_lead", [](const F& odometry, Window& window, nb::handle key, double time, nb::handle from, const Loss& loss) {
    require_unused(&window, "Window");
    if constexpr (detail::HasValidate<F>::value) odometry.validate();
    window.add_state(key_of(key), time, key_of(from), odometry, loss);
  });
}

/// What is known of a state of an agent that keeps lock before any measurement.
template <class V>
struct PythonNothingKnown {
  std::shared_ptr<nb::object> function;
  Prior<V> operator()(const V& seen) const {
    const nb::gil_scoped_acquire gil;
    return returned_factor<Prior<V>>("nothing_known(state)", (*function)(seen));
  }
};

inline StreamEnd end_of(nb::handle given) {
  if (nb::isinstance<Key>(given)) return nb::cast<Key>(given);
  if (nb::isinstance<Agent>(given)) return nb::cast<Agent>(given);
  throw nb::type_error(("an end of a stream is an Agent or the Key of a landmark, not " + nb::cast<std::string>(nb::repr(given))).c_str());
}

template <class F, class Missing>
struct PythonMissing {
  std::shared_ptr<nb::object> function;
  Missing operator()(const F& last, int m) const {
    const nb::gil_scoped_acquire gil;
    return returned_factor<Missing>("missing(last, m)", (*function)(last, m));
  }
};

template <class F>
AnyStreamId expected(Schedule& schedule, Window& window, nb::handle a, nb::handle b, double first, double period) {
  require_unused(&window, "Window");
  return schedule.expect<F>(end_of(a), end_of(b), first, period);
}

/// Measurements that a Schedule expects.
template <class F>
void bind_stream(nb::class_<F>& c) {
  c.def_static("_expect", &expected<F>);
  c.def("_receive", [](const F& factor, Schedule& schedule, Window& window, const AnyStreamId& id, double time, const Loss& loss) {
    require_unused(&window, "Window");
    if (dynamic_cast<const Receiver<F>*>(&schedule.stream(id)) == nullptr)
      throw nb::type_error(("this stream takes no " + factor_name<F>() + " on these variables").c_str());
    StreamId<F> typed;
    static_cast<AnyStreamId&>(typed) = id;
    schedule.receive(typed, time, factor, loss);
  });
}

template <class F>
void bind_measurement(nb::module_& m) {
  auto c = bind_factor<F>(m);
  bind_stream(c);
}

/// The same, and a missing one may say Missing.
template <class Missing, class F>
void bind_stream_with_missing(nb::class_<F>& c) {
  bind_stream(c);
  c.def_static(
      "_expect_or",
      [](Schedule& schedule, Window& window, nb::handle a, nb::handle b, double first, double period, nb::object missing) -> AnyStreamId {
        require_unused(&window, "Window");
        return schedule.expect<F>(end_of(a), end_of(b), first, period, PythonMissing<F, Missing>{held(std::move(missing))});
      });
}

}  // namespace holdfast::python
