// Where a solve may start, and files.
#include <nanobind/stl/unordered_map.h>

#include <holdfast/adapters/files/convert.hpp>
#include <holdfast/adapters/files/problem.hpp>
#include <holdfast/adapters/files/to_dataset.hpp>
#include <holdfast/graph/files/files.hpp>
#include <holdfast/graph/files/tum.hpp>
#include <holdfast/graph/starts/chordal.hpp>

#include "bind.hpp"

namespace holdfast::python {
namespace {

Format format_of(const std::string& path) {
  const std::optional<Format> format = format_of_name(path);
  if (!format) fail<BadFile>(path, ": the name says no format; end it in .g2o, .pyfg, .graph or .toro");
  return *format;
}

void write_problem(const std::string& path, const Graph& graph, const Values& values) {
  const Format format = format_of(path);
  const Conversion written = converted(to_dataset(graph, values, format), format);
  write_dataset(path, written.dataset, format);
}

}  // namespace

void bind_starts(nb::module_& m) {
  m.def(
      "read_problem",
      [](const std::string& path, const Loss& loss, const std::string& start) {
        ProblemOptions options;
        options.loss = loss;
        options.start = start_named(start);
        Problem problem = make_problem(read_dataset(path), options);
        return nb::make_tuple(std::move(problem.graph), std::move(problem.start));
      },
      "path"_a, "loss"_a = Loss(), "start"_a = "file",
      "(graph, values) of a PyFG, g2o or TORO file; start: file, odometry, chordal, convex");
  m.def(
      "read_times",
      [](const std::string& path) {
        nb::dict times;
        for (const auto& [key, time] : vertex_times(read_dataset(path))) times[nb::cast(key)] = time;
        return times;
      },
      "path"_a, "{key: seconds} of the vertices of a file that have a time stamp");
  m.def(
      "write_problem", &write_problem, "path"_a, "graph"_a, "values"_a,
      "relative poses, priors, relative points and ranges into a .g2o, .pyfg, .graph or .toro file; what the format cannot hold is named");
  m.def(
      "write_tum",
      [](const std::string& directory, const Values& values, const nb::dict& times) {
        std::unordered_map<Key, double> of_keys;
        for (const auto& [key, time] : times) of_keys[key_of(key)] = nb::cast<double>(time);
        return write_tum_directory(directory, values, of_keys);
      },
      "directory"_a, "values"_a, "times"_a = nb::dict(),
      "the poses of each agent into directory/A.tum, which evo reads; returns the paths. times: {key: seconds}; none: the steps");

  nb::class_<RelaxedStart>(m, "RelaxedStart")
      .def_ro("cost_centroid", &RelaxedStart::cost_centroid)
      .def_ro("relaxed", &RelaxedStart::relaxed)
      .def_ro("is_convex", &RelaxedStart::is_convex)
      .def_ro("cost", &RelaxedStart::cost)
      .def("__repr__", &RelaxedStart::str);
  m.def(
      "relaxed_start",
      [](const Graph& graph, Values& values, const Options& options) {
        const Writing writing(&values, "Values");
        const Reading reading(&graph, "Graph");
        auto found = [&] {
          const nb::gil_scoped_release release;
          return relaxed_start(graph, values, options);
        }();
        raise_function_errors(graph);
        return found;
      },
      "graph"_a, "values"_a, "options"_a = Options(), "every position from the convex relaxation, whatever the values given");
  m.def(
      "convex_start",
      [](const Graph& graph, Values& values, Backend& backend) {
        const Writing writing(&values, "Values"), solving(&backend, "back-end");
        const Reading reading(&graph, "Graph");
        auto found = [&] {
          const nb::gil_scoped_release release;
          return convex_start(graph, values, backend);
        }();
        raise_function_errors(graph);
        return std::make_tuple(found.start, found.refined);
      },
      "graph"_a, "values"_a, "backend"_a, "from no initial guess: relaxed_start, then the back-end. Returns (RelaxedStart, Summary)");
  m.def(
      "chordal_start",
      [](const Graph& graph, Values& values) {
        require_unused(&values, "Values");
        return chordal_start(graph, values);
      },
      "graph"_a, "values"_a, "poses from their relative poses alone; False, and the values as they were, where those do not place all");
}

}  // namespace holdfast::python
