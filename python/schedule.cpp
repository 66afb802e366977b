#include <holdfast/solvers/window/schedule.hpp>

#include "bind_window.hpp"

namespace holdfast::python {
namespace {

Arrival arrival_named(const std::string& name) {
  for (const Arrival one : {Arrival::received, Arrival::rejected, Arrival::dropped, Arrival::out_of_range})
    if (name == to_string(one)) return one;
  fail<BadOption>("why = '", name, "', must be received, rejected, dropped or out_of_range");
}

template <class V>
void bind_lock(nb::module_& m) {
  m.def("_keep_lock", [](Window& window, nb::handle agent, const Prior<V>&, nb::object nothing_known, int memory, int recent,
                         double rejected, int patience, int settled) {
    require_unused(&window, "Window");
    window.keep_lock(agent_of(agent), LockOptions{memory, recent, rejected, patience, settled},
                     PythonNothingKnown<V>{held(std::move(nothing_known))});
  });
}

}  // namespace

void bind_schedule(nb::module_& m) {
  bind_lock<Motion2>(m);
  bind_lock<Motion3>(m);
  bind_lock<Accel2>(m);
  bind_lock<Accel3>(m);
  bind_lock<Turning2>(m);
  nb::class_<AnyStreamId>(m, "StreamId");
  nb::class_<Schedule>(m, "_Schedule", "Which measurements were expected, and what became of each; see schedule.hpp.")
      .def(nb::init<Window&>(), "window"_a, nb::keep_alive<1, 2>())
      .def("_lose",
           [](Schedule& s, Window& window, const AnyStreamId& id, double time, const std::string& why) {
             require_unused(&window, "Window");
             s.lose(id, time, arrival_named(why));
           })
      .def("_close",
           [](Schedule& s, Window& window, double now) {
             require_unused(&window, "Window");
             s.close(now);
           })
      .def("judge", &Schedule::judge, "report"_a, "what its loss does not believe is rejected")
      .def(
          "count",
          [](const Schedule& s, const AnyStreamId& id, const std::string& arrival) { return s.stream(id).count(arrival_named(arrival)); },
          "stream"_a, "arrival"_a, "since the beginning")
      .def(
          "entries",
          [](const Schedule& s, const AnyStreamId& id) {
            nb::list all;
            for (const Stream::Entry& one : s.stream(id).entries()) all.append(nb::make_tuple(one.number, to_string(one.arrival)));
            return all;
          },
          "stream"_a, "[(number, arrival)] of those whose states may be in the window")
      .def(
          "save",
          [](const Schedule& s) {
            const std::string bytes = s.save();
            return nb::bytes(bytes.data(), bytes.size());
          },
          "for Window.save(path, note)")
      .def(
          "restore", [](Schedule& s, const nb::bytes& bytes) { s.restore(std::string_view(bytes.c_str(), bytes.size())); }, "bytes"_a);
}

}  // namespace holdfast::python
