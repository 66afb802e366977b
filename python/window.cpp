#include <holdfast/solvers/table.hpp>
#include <holdfast/solvers/window/window.hpp>

#include "bind.hpp"

namespace holdfast::python {
namespace {

Window& unused(Window& window) {
  require_unused(&window, "Window");
  return window;
}
const Window& readable(const Window& window) {
  require_readable(&window, "Window");
  return window;
}

WindowOptions::Leaving leaving_named(const std::string& name) {
  if (name == "marginalize") return WindowOptions::Leaving::marginalize;
  if (name == "drop") return WindowOptions::Leaving::drop;
  fail<BadOption>("leaving = '", name, "', must be marginalize or drop");
}

std::unique_ptr<Backend> backend_of(const std::variant<std::string, const Backend*>& given) {
  if (const auto* name = std::get_if<std::string>(&given)) return make_backend(*name);
  return copy_of(*std::get<const Backend*>(given));
}

struct PythonLeaving {
  std::shared_ptr<nb::object> function;
  void operator()(Key key, double time) const {
    const nb::gil_scoped_acquire gil;
    (*function)(key, time);
  }
};

// A window holds its on_leaving, which may hold the window: Python's collector has to see that.
int traverse_window(PyObject* self, visitproc visit, void* arg) {
  Py_VISIT(Py_TYPE(self));
  if (!nb::inst_ready(self)) return 0;
  const auto* leaving = nb::inst_ptr<Window>(self)->options().on_leaving.target<PythonLeaving>();
  if (leaving != nullptr && leaving->function.use_count() == 1) Py_VISIT(leaving->function->ptr());
  return 0;
}
int clear_window(PyObject* self) {
  if (nb::inst_ready(self)) *nb::inst_ptr<Window>(self) = Window();
  return 0;
}
PyType_Slot window_slots[] = {
    {Py_tp_traverse, reinterpret_cast<void*>(traverse_window)}, {Py_tp_clear, reinterpret_cast<void*>(clear_window)}, {0, nullptr}};

void make_window(Window* self, double lag, int max_states, const std::string& leaving, double arrival_limit, bool collapse,
                 const std::variant<std::string, const Backend*>& backend, bool covariances, bool report, double deadline, double max_gap,
                 nb::object on_leaving) {
  WindowOptions options;
  options.lag = lag;
  options.max_states = max_states;
  options.leaving = leaving_named(leaving);
  options.arrival_limit = arrival_limit;
  options.collapse = collapse;
  options.covariances = covariances;
  options.report = report;
  options.deadline = deadline;
  options.max_gap = max_gap;
  if (!on_leaving.is_none()) options.on_leaving = PythonLeaving{held(std::move(on_leaving))};
  new (self) Window(options, backend_of(backend));
}

/// Lets other threads run; they are refused this window.
WindowStep step(Window& window, double now) {
  const Writing writing(&window, "Window");
  WindowStep step = [&] {
    const nb::gil_scoped_release release;
    // Python keeps what it is given: moved out, as Marginals cannot be copied. The window makes the next step's anew.
    return std::move(const_cast<WindowStep&>(window.step(now)));
  }();
  raise_function_errors(window.graph());
  return step;
}

template <class V>
nb::object cast_state(const Window& window, Agent agent, double time) {
  return nb::cast(window.state_at<V>(agent, time));
}
template <class V>
Eigen::MatrixXd covariance(const Window& window, Agent agent, double time) {
  return window.covariance_at<V>(agent, time);
}

/// fn(V*) for the type of the agent's states.
template <class Fn, class... V>
auto for_state_of(const Window& window, Agent agent, const Fn& fn, const std::tuple<V*...>&) {
  const Key newest = window.newest_key(agent);
  std::optional<decltype(fn(static_cast<Point2*>(nullptr)))> result;
  (void)((window.values().contains<V>(newest) && (result = fn(static_cast<V*>(nullptr)), true)) || ...);
  if (!result) fail<BadType>("the states of agent ", agent, " are of a type that Python has not");
  return *result;
}
using States = std::tuple<Point2*, Point3*, Motion2*, Motion3*, Accel2*, Accel3*, Turning2*, Scalar*, Pose2*, Pose3*>;

template <class... V>
void bind_states(nb::class_<Window>& c, const std::tuple<V*...>&) {
  (c.def("_add_state", [](Window& w, nb::handle key, double time, const V& start) { unused(w).add_state(key_of(key), time, start); }), ...);
  (c.def("_add_landmark", [](Window& w, nb::handle key, const V& start) { unused(w).add_landmark(key_of(key), start); }), ...);
  (c.def("_add_beacon", [](Window& w, nb::handle key, const V& known) { unused(w).add_beacon(key_of(key), known); }), ...);
}

void bind_step(nb::module_& m) {
  nb::class_<WindowStep>(m, "WindowStep")
      .def_ro("time", &WindowStep::time, "[s] now")
      .def_ro("summary", &WindowStep::summary)
      .def_ro("left", &WindowStep::left, "the states that left")
      .def_ro("lost", &WindowStep::lost, "agents whose inliers no longer explain their measurements")
      .def_ro("reacquired", &WindowStep::reacquired)
      .def_ro("arrivals_let_go", &WindowStep::arrivals_let_go)
      .def_ro("removed", &WindowStep::removed, "factors whose residual was not finite, in words")
      .def_ro("marginals", &WindowStep::marginals, "where asked for")
      .def_ro("report", &WindowStep::report, "where asked for")
      .def_prop_ro("seconds", [](const WindowStep& s) { return s.seconds.total(); })
      .def_ro("deadline_kept", &WindowStep::deadline_kept)
      .def("__repr__", [](const WindowStep& s) { return "WindowStep at " + std::to_string(s.time) + " s: " + s.summary.str(); });
}

void bind_time(nb::class_<Window>& c) {
  c.def(
       "state_at",
       [](Window& w, nb::handle agent, double time) {
         const Agent a = agent_of(agent);
         return for_state_of(
             unused(w), a, [&](auto* v) { return cast_state<std::remove_pointer_t<decltype(v)>>(w, a, time); }, States());
       },
       "agent"_a, "time"_a, "the agent's state at any time from its first state on [s]")
      .def(
          "covariance_at",
          [](Window& w, nb::handle agent, double time) {
            const Agent a = agent_of(agent);
            return for_state_of(
                unused(w), a, [&](auto* v) { return covariance<std::remove_pointer_t<decltype(v)>>(w, a, time); }, States());
          },
          "agent"_a, "time"_a, "of a state, or of the newest one moved on")
      .def(
          "newest", [](const Window& w, nb::handle agent) { return readable(w).newest_key(agent_of(agent)); }, "agent"_a,
          "the key of its newest state")
      .def(
          "time", [](const Window& w, nb::handle key) { return readable(w).time(key_of(key)); }, "key"_a, "of a state [s]")
      .def_prop_ro("newest_time", [](const Window& w) { return readable(w).newest_time(); })
      .def(
          "states", [](const Window& w, nb::handle agent) { return readable(w).states(agent_of(agent)); }, "agent"_a, "oldest first")
      .def_prop_ro("agents", [](const Window& w) { return readable(w).agents(); });
}

void bind_members(nb::class_<Window>& c) {
  c.def(
       "at", [](Window& w, nb::handle agent, double time) { return unused(w).at(agent_of(agent), time); }, "agent"_a, "time"_a,
       "the key of the agent's state at this time; made, if there is none, from its motion")
      .def(
          "has_agent", [](const Window& w, nb::handle agent) { return readable(w).has_agent(agent_of(agent)); }, "agent"_a)
      .def(
          "remove_agent", [](Window& w, nb::handle agent) { unused(w).remove_agent(agent_of(agent)); }, "agent"_a,
          "all its states leave now")
      .def(
          "remove_landmark", [](Window& w, nb::handle key) { unused(w).remove_landmark(key_of(key)); }, "key"_a)
      .def(
          "add_from", [](Window& w, const Graph& other, FactorId id) { return unused(w).add_from(other, id); }, "graph"_a, "id"_a,
          "a copy of a factor of another graph, with its loss and weight")
      .def(
          "remove", [](Window& w, FactorId id) { unused(w).remove(id); }, "id"_a);
}

}  // namespace

void bind_window(nb::module_& m) {
  nb::exception<BadTime>(m, "BadTime", m.attr("Error").ptr());
  bind_step(m);
  nb::class_<Window> c(m, "Window", nb::type_slots(window_slots),
                       "A sliding window: a fixed-lag smoother over any variables and factors; see window.hpp.");
  constexpr double kNever = std::numeric_limits<double>::infinity();
  c.def("__init__", &make_window, nb::kw_only(), "lag"_a = kNever, "max_states"_a = 0, "leaving"_a = "marginalize",
        "arrival_limit"_a = kNever, "collapse"_a = true, "backend"_a = "irls", "covariances"_a = false, "report"_a = false,
        "deadline"_a = kNever, "max_gap"_a = kNever, "on_leaving"_a = nb::none(), "backend: a name, or a Backend (copied)");
  bind_states(c, States());
  bind_members(c);
  bind_time(c);
  c.def("step", &step, "now"_a, "solve, answer, let the oldest leave; now [s]")
      .def_prop_ro(
          "values", [](const Window& w) { return Values(readable(w).values()); }, "a copy")
      .def_prop_ro(
          "graph", [](const Window& w) { return Graph(readable(w).graph()); }, "a copy")
      .def(
          "save",
          [](const Window& w, const std::string& path, const nb::bytes& note) {
            readable(w).save(path, std::string_view(note.c_str(), note.size()));
          },
          "path"_a, "note"_a = nb::bytes("", 0), "the whole window and a note, written whole or not at all")
      .def(
          "restore",
          [](Window& w, const std::string& path) {
            const std::string note = unused(w).restore(path);
            return nb::bytes(note.data(), note.size());
          },
          "path"_a, "into a window with the same options and motion models; returns the note");
}

}  // namespace holdfast::python
