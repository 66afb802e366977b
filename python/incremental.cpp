#include <holdfast/solvers/incremental/incremental.hpp>

#include "bind.hpp"

namespace holdfast::python {
namespace {

Incremental& unused(Incremental& smoother) {
  require_unused(&smoother, "Incremental");
  return smoother;
}
const Incremental& readable(const Incremental& smoother) {
  require_readable(&smoother, "Incremental");
  return smoother;
}
/// Lets other threads run; they are refused this smoother.
template <class Work>
auto alone(Incremental& smoother, const Work& work) {
  const Writing writing(&smoother, "Incremental");
  const nb::gil_scoped_release release;
  return work();
}

}  // namespace

void bind_incremental(nb::module_& m) {
  const nb::object base = m.attr("Error");
  nb::exception<Underdetermined>(m, "Underdetermined", base.ptr());
  nb::class_<IncrementalStep>(m, "IncrementalStep")
      .def_ro("steps", &IncrementalStep::steps, "Gauss–Newton steps")
      .def_ro("relinearized", &IncrementalStep::relinearized, "variables")
      .def_ro("eliminated", &IncrementalStep::eliminated, "variables eliminated again")
      .def_ro("reordered", &IncrementalStep::reordered)
      .def_ro("settled", &IncrementalStep::settled, "no variable is further than relinearize from where it was linearised")
      .def_ro("batch", &IncrementalStep::batch, "the steps were not enough: irls solved the whole graph")
      .def_ro("seconds", &IncrementalStep::seconds);
  nb::class_<Incremental>(m, "Incremental",
                          "The whole history, updated in place: insert() variables, add() factors, update(); at() and values() are the "
                          "estimate. See holdfast/solvers/incremental/incremental.hpp.")
      .def(
          "__init__",
          [](Incremental* self, double relinearize, double propagate, int most_steps, double reorder) {
            new (self) Incremental(IncrementalOptions{relinearize, propagate, most_steps, reorder});
          },
          "relinearize"_a = 1e-3, "propagate"_a = 1e-5, "most_steps"_a = 5, "reorder"_a = 20.0)
      .def(
          "insert_from", [](Incremental& i, const Values& values, Key key) { unused(i).insert_from(values, key); }, "values"_a, "key"_a)
      .def(
          "add_from", [](Incremental& i, const Graph& graph, FactorId id) { return unused(i).add_from(graph, id); }, "graph"_a, "id"_a)
      .def(
          "remove", [](Incremental& i, FactorId id) { unused(i).remove(id); }, "id"_a)
      .def(
          "fix", [](Incremental& i, Key key) { unused(i).fix(key); }, "key"_a)
      .def(
          "erase", [](Incremental& i, Key key) { unused(i).erase(key); }, "key"_a)
      .def(
          "marginalize", [](Incremental& i, const std::vector<Key>& keys) { unused(i).marginalize(keys); }, "keys"_a)
      .def("update", [](Incremental& i) { return alone(i, [&] { return IncrementalStep(i.update()); }); })
      .def(
          "finish", [](Incremental& i) { return alone(i, [&] { return i.finish(); }); }, "to full accuracy: the batch answer")
      .def("values", [](const Incremental& i) { return Values(readable(i).values()); })
      .def("cost", [](Incremental& i) { return alone(i, [&] { return i.cost(); }); })
      .def(
          "covariance", [](Incremental& i, const std::vector<Key>& keys) { return unused(i).covariance(keys); }, "keys"_a,
          "of these variables together")
      .def_prop_ro(
          "graph", [](const Incremental& i) { return Graph(readable(i).graph()); }, "a copy")
      .def("__len__", [](const Incremental& i) { return readable(i).size(); });
}

}  // namespace holdfast::python
