// What is known of an answer: covariances, and which measurements were believed.
#include <holdfast/solvers/marginals.hpp>
#include <holdfast/solvers/outlier_report.hpp>
#include <holdfast/solvers/window/marginalize.hpp>

#include "bind.hpp"

namespace holdfast::python {
namespace {

using Square = Eigen::Map<const Eigen::MatrixXd>;

Eigen::MatrixXd square(const std::vector<double>& numbers) {
  const auto n = static_cast<Eigen::Index>(std::lround(std::sqrt(static_cast<double>(numbers.size()))));
  return Square(numbers.data(), n, n);
}

}  // namespace

void bind_answers(nb::module_& m) {
  nb::exception<UnobservableError>(m, "UnobservableError", m.attr("Error").ptr());

  nb::class_<Marginals>(m, "Marginals")
      .def(
          "__init__",
          [](Marginals* self, const Graph& graph, const Values& values) {
            new (self) Marginals(without_gil(graph, values, [&] { return Marginals(graph, values); }));
          },
          "graph"_a, "values"_a)
      .def(
          "covariance", [](const Marginals& c, Key key) { return square(c.covariance(key)); }, "key"_a)
      .def(
          "joint", [](const Marginals& c, Key a, Key b) { return square(c.joint(a, b)); }, "a"_a, "b"_a)
      .def("is_observable", &Marginals::is_observable, "key"_a)
      .def("unobservable", &Marginals::unobservable);

  m.def(
      "marginalize",
      [](Graph& graph, Values& values, const std::vector<Key>& keys) {
        require_unused(&graph, "Graph");
        require_unused(&values, "Values");
        marginalize(graph, values, keys);
        raise_function_errors(graph);
      },
      "graph"_a, "values"_a, "keys"_a, "the keys leave graph and values; what is known through them stays as priors on their neighbours");

  nb::class_<MeasurementReport>(m, "MeasurementReport")
      .def_ro("id", &MeasurementReport::id)
      .def_ro("factor", &MeasurementReport::factor)
      .def_ro("keys", &MeasurementReport::keys)
      .def_ro("raw", &MeasurementReport::raw, "in the units of the measurement; empty where the factor does not say")
      .def_ro("whitened", &MeasurementReport::whitened, "[sigmas]")
      .def_ro("weight", &MeasurementReport::weight, "1 is believed, 0 is ignored")
      .def_prop_ro("verdict", [](const MeasurementReport& one) { return std::string(to_string(one.verdict)); });
  m.def(
      "outlier_report",
      [](const Graph& graph, const Values& values) { return without_gil(graph, values, [&] { return outlier_report(graph, values); }); },
      "graph"_a, "values"_a, "which measurements the losses believe at these values");
}

}  // namespace holdfast::python
