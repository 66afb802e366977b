#include <holdfast/solvers/window/trust.hpp>

#include "bind.hpp"

namespace holdfast::python {
namespace {

const char* to_text(Trust::Change change) {
  constexpr const char* kNames[] = {"none", "lost", "regained"};
  return kNames[static_cast<int>(change)];
}

nb::list listed(const std::vector<Trust::Judged>& judged) {
  nb::list all;
  for (const Trust::Judged& one : judged) all.append(nb::make_tuple(one.ticket, one.fits));
  return all;
}

}  // namespace

void bind_trust(nb::module_& m) {
  nb::class_<Trust>(m, "Trust", "Who is to be believed just now; see holdfast/solvers/window/trust.hpp.")
      .def(
          "__init__",
          [](Trust* self, int recent, double gate, double lost, double regained) {
            new (self) Trust(TrustOptions{recent, gate, lost, regained});
          },
          "recent"_a = 8, "gate"_a = 3.0, "lost"_a = 0.5, "regained"_a = 0.75)
      .def("fits", &Trust::fits, "squared_norm"_a, "dim"_a)
      .def(
          "judge",
          [](Trust& trust, std::uint64_t party, std::uint64_t ticket, bool fits) { return to_text(trust.judge(party, ticket, fits)); },
          "party"_a, "ticket"_a, "fits"_a, "one more measurement of this party: 'none', 'lost' or 'regained'")
      .def("is_believed", &Trust::is_believed, "party"_a)
      .def("disbelieve", &Trust::disbelieve, "party"_a)
      .def(
          "latest", [](const Trust& trust, std::uint64_t party) { return listed(trust.latest(party)); }, "party"_a, "[(ticket, fits)]")
      .def(
          "doubtful", [](const Trust& trust, std::uint64_t party) { return listed(trust.doubtful(party)); }, "party"_a)
      .def_prop_ro("disbelieved", &Trust::disbelieved);
  m.def(
      "innovation",
      [](const Graph& one, const Values& values, const Marginals& marginals) {
        return without_gil(one, values, [&] { return innovation(one, values, marginals); });
      },
      "one"_a, "values"_a, "marginals"_a, "rᵀ (I + J P Jᵀ)⁻¹ r of the one factor of a graph, given what is known without it");
}

}  // namespace holdfast::python
