#include <holdfast/solvers/incremental/incremental.hpp>

#include "bind.hpp"

namespace holdfast::python {

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
      .def("insert_from", &Incremental::insert_from, "values"_a, "key"_a)
      .def("add_from", &Incremental::add_from, "graph"_a, "id"_a)
      .def("remove", &Incremental::remove, "id"_a)
      .def("fix", &Incremental::fix, "key"_a)
      .def("erase", &Incremental::erase, "key"_a)
      .def("marginalize", &Incremental::marginalize, "keys"_a)
      .def("update", &Incremental::update, nb::call_guard<nb::gil_scoped_release>(), nb::rv_policy::copy)
      .def("finish", &Incremental::finish, nb::call_guard<nb::gil_scoped_release>(), "to full accuracy: the batch answer")
      .def("values", &Incremental::values)
      .def("cost", &Incremental::cost, nb::call_guard<nb::gil_scoped_release>())
      .def("covariance", &Incremental::covariance, "keys"_a, "of these variables together")
      .def_prop_ro("graph", &Incremental::graph, nb::rv_policy::reference_internal)
      .def("__len__", &Incremental::size);
}

}  // namespace holdfast::python
