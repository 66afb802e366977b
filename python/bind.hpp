// What the sources of the Python module share. One source a room, so that each compiles on its own.
#pragma once

#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/function.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <holdfast/graph/graph.hpp>
#include <sstream>

#include "held.hpp"

namespace holdfast::python {

namespace nb = nanobind;
using namespace nb::literals;

void bind_variables(nb::module_& m);
void bind_graph(nb::module_& m);
void bind_losses(nb::module_& m);
void bind_pose_factors(nb::module_& m);
void bind_range_factors(nb::module_& m);
void bind_radio_factors(nb::module_& m);
void bind_bearing_factors(nb::module_& m);
void bind_motion_factors(nb::module_& m);
void bind_functions(nb::class_<Graph>& graph);
extern PyType_Slot graph_slots[];
/// RuntimeError with what a function of the graph raised since it was last asked; KeyboardInterrupt where that was Ctrl-C.
void raise_function_errors(const Graph& graph);
void raise_interrupt();
void bind_backends(nb::module_& m);
void bind_answers(nb::module_& m);
void bind_robust(nb::module_& m);
void bind_starts(nb::module_& m);
void bind_window(nb::module_& m);
void bind_schedule(nb::module_& m);
void bind_trust(nb::module_& m);
void bind_incremental(nb::module_& m);

/// What evaluates a graph lets other threads run: a function factor takes the GIL for its call, and a thread that evaluates the same graph
/// while it holds the GIL would wait for the one, and that one for the GIL.
template <class Work>
auto without_gil(const Graph& graph, const Values& values, const Work& work) {
  const Reading reading_graph(&graph, "Graph");
  const Reading reading_values(&values, "Values");
  auto result = [&] {
    const nb::gil_scoped_release release;
    return work();
  }();
  raise_function_errors(graph);
  return result;
}

/// A callable that threads without the GIL may hold and let go.
std::shared_ptr<nb::object> held(nb::object callable);
/// Of a Key, its text, or its bits; of an Agent or its text. TypeError for anything else, BadKey for what is wrong with a text.
Key key_of(nb::handle given);
Agent agent_of(nb::handle given);
/// A back-end with the same name and options.
std::unique_ptr<Backend> copy_of(const Backend& backend);

template <class T>
std::string printed(const T& x) {
  std::ostringstream out;
  out << x;
  return out.str();
}

/// Anything that NumPy makes a matrix of this size of: an array, a list.
template <class M>
M numbers(const char* what, nb::handle given) {
  try {
    if (!given.is_none())  // of which NumPy makes a NaN
      return nb::cast<M>(nb::module_::import_("numpy").attr("ascontiguousarray")(given, "float64"));
  } catch (const std::bad_cast&) {
  } catch (const nb::python_error&) {
  }
  std::string size = std::to_string(M::RowsAtCompileTime);
  if (M::ColsAtCompileTime != 1) size += " x " + std::to_string(M::ColsAtCompileTime);
  throw nb::type_error((std::string(what) + " takes " + size + " numbers, not " + nb::cast<std::string>(nb::repr(given))).c_str());
}

}  // namespace holdfast::python
