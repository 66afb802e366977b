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
      .def_ro("seconds", &IncrementalStep::seconds)
      .def_ro("findings", &IncrementalStep::findings, "if asked for: ranges at zero distance and mirror images that it brought")
      .def_ro("gone", &IncrementalStep::gone, "if asked for: those of before that it ended")
      .def_ro("report", &IncrementalStep::report, "if asked for: of the factors that came, and of those that were linearised anew");
  nb::class_<Incremental>(m, "Incremental",
                          "The whole history, updated in place: insert() variables, add() factors, update(); at() and values() are the "
                          "estimate. See holdfast/solvers/incremental/incremental.hpp.")
      .def(
          "__init__",
          [](Incremental* self, double relinearize, double propagate, int most_steps, double reorder, bool findings, bool report) {
            new (self) Incremental(IncrementalOptions{relinearize, propagate, most_steps, reorder, findings, report});
          },
          "relinearize"_a = 0.05, "propagate"_a = 1e-5, "most_steps"_a = 5, "reorder"_a = 20.0, "findings"_a = false, "report"_a = false)
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
      .def(
          "save",
          [](const Incremental& i, const std::string& path, const nb::bytes& note) {
            readable(i).save(path, std::string_view(note.c_str(), note.size()));
          },
          "path"_a, "note"_a = nb::bytes("", 0), "the whole smoother into a file, written whole or not at all")
      .def(
          "restore",
          [](Incremental& i, const std::string& path) {
            const std::string note = unused(i).restore(path);
            return nb::bytes(note.data(), note.size());
          },
          "path"_a, "in the place of all there is; what follows has the same bits. Returns the note")
      .def("__len__", [](const Incremental& i) { return readable(i).size(); });
}

}  // namespace holdfast::python
