// Against outliers, and for proof: graduated non-convexity, consistent loops, certificates.
#include <holdfast/solvers/certificate.hpp>
#include <holdfast/solvers/gnc.hpp>
#include <holdfast/solvers/pairwise_consistency.hpp>
#include <holdfast/solvers/range_consistency.hpp>

#include "bind.hpp"

namespace holdfast::python {
namespace {

void bind_gnc(nb::module_& m) {
  nb::class_<Gnc, Backend>(m, "Gnc")
      .def(
          "weight", [](const Gnc& gnc, FactorId id) { return require_readable(&gnc, "back-end"), gnc.weight(id); }, "id"_a,
          "ω in [0, 1] after the last solve")
      .def_prop_ro(
          "weights",
          [](const Gnc& gnc) {
            require_readable(&gnc, "back-end");
            nb::dict all;
            for (const Gnc::TermWeight& term : gnc.weights()) all[nb::cast(term.id)] = term.weight;
            return all;
          },
          "{FactorId: ω} of every term that it weighs, after the last solve")
      .def_prop_ro("mu_factor", [](const Gnc& gnc) { return gnc.gnc_options.mu_factor; })
      .def_prop_ro("known_inliers", [](const Gnc& gnc) { return gnc.gnc_options.known_inliers; });
  const GncOptions usual;
  m.def(
      "gnc",
      [](const Backend& inner, double mu_factor, bool pairs, bool second_chances, int max_outer_iterations,
         const std::vector<FactorId>& known_inliers) {
        const GncOptions options{mu_factor, pairs, second_chances, max_outer_iterations, known_inliers};
        return gnc(copy_of(inner), options).release();
      },
      "inner"_a, "mu_factor"_a = usual.mu_factor, "pairs"_a = usual.pairs, "second_chances"_a = usual.second_chances,
      "max_outer_iterations"_a = usual.max_outer_iterations, "known_inliers"_a = std::vector<FactorId>(), nb::rv_policy::take_ownership,
      "graduated non-convexity round a copy of a back-end; see holdfast/solvers/gnc.hpp");
}

void bind_certificate(nb::module_& m) {
  nb::class_<Certificate>(m, "Certificate")
      .def_prop_ro("verdict", [](const Certificate& c) { return std::string(to_string(c.verdict)); })
      .def_prop_ro("is_global", &Certificate::is_global, "of the graph's own cost, to the tolerance")
      .def_ro("cost", &Certificate::cost)
      .def_ro("bound", &Certificate::bound, "no values have a cost below it")
      .def_prop_ro("gap", &Certificate::gap)
      .def_prop_ro("relative_gap", &Certificate::relative_gap)
      .def_ro("terms", &Certificate::terms)
      .def_ro("left_out", &Certificate::left_out, "terms that count as 0 in the bound")
      .def_ro("left_out_cost", &Certificate::left_out_cost)
      .def_ro("left_out_first", &Certificate::left_out_first)
      .def_ro("positive_definite", &Certificate::positive_definite)
      .def_ro("eta", &Certificate::eta)
      .def_ro("is_isotropic", &Certificate::is_isotropic)
      .def_ro("relaxation", &Certificate::relaxation)
      .def_ro("chordal_cost", &Certificate::chordal_cost)
      .def_ro("chordal_bound", &Certificate::chordal_bound)
      .def_ro("chordal_move", &Certificate::chordal_move, "[m]")
      .def_ro("chordal_turn", &Certificate::chordal_turn, "[rad]")
      .def_ro("seconds", &Certificate::seconds)
      .def("__repr__", &Certificate::str);
  m.def(
      "certify",
      [](const Graph& graph, const Values& values, double tolerance, bool ask_chordal, bool ask_relaxation) {
        return without_gil(graph, values, [&] { return certify(graph, values, {tolerance, ask_chordal, ask_relaxation}); });
      },
      "graph"_a, "values"_a, "tolerance"_a = 1e-7, "ask_chordal"_a = true, "ask_relaxation"_a = true,
      "is it the global minimum? A lower bound of the cost over all values; see holdfast/solvers/certificate.hpp");
}

void bind_consistency(nb::module_& m) {
  nb::class_<ConsistentLoops>(m, "ConsistentLoops")
      .def_ro("kept", &ConsistentLoops::kept)
      .def_ro("rejected", &ConsistentLoops::rejected)
      .def_ro("untested", &ConsistentLoops::untested, "of the kept ones")
      .def_ro("tracks", &ConsistentLoops::tracks)
      .def_ro("groups", &ConsistentLoops::groups)
      .def_ro("pairs", &ConsistentLoops::pairs)
      .def_ro("disagreeing", &ConsistentLoops::disagreeing)
      .def_ro("noise_scale", &ConsistentLoops::noise_scale)
      .def_ro("is_exact", &ConsistentLoops::is_exact)
      .def_ro("seconds", &ConsistentLoops::seconds)
      .def("__repr__", &ConsistentLoops::str);
  m.def(
      "consistent_loops",
      [](const Graph& graph, double false_alarm, bool second_look, double informative, std::size_t most_pairs, double time_limit,
         double noise_scale, const std::vector<FactorId>& odometry) {
        const PairwiseConsistencyOptions options{false_alarm, second_look, informative, most_pairs, time_limit, noise_scale, odometry};
        return without_gil(graph, Values(), [&] { return consistent_loops(graph, options); });
      },
      "graph"_a, "false_alarm"_a = 1e-4, "second_look"_a = true, "informative"_a = 1.0, "most_pairs"_a = 20'000'000, "time_limit"_a = 0.5,
      "noise_scale"_a = 0.0, "odometry"_a = std::vector<FactorId>(),
      "loop closures that agree with each other; see holdfast/solvers/pairwise_consistency.hpp");
  nb::class_<ConsistentRanges>(m, "ConsistentRanges")
      .def_ro("kept", &ConsistentRanges::kept)
      .def_ro("rejected", &ConsistentRanges::rejected)
      .def_ro("untested", &ConsistentRanges::untested, "of the kept ones")
      .def_ro("groups", &ConsistentRanges::groups)
      .def_ro("windows", &ConsistentRanges::windows)
      .def_ro("decided", &ConsistentRanges::decided, "windows that judged")
      .def_ro("noise_scale", &ConsistentRanges::noise_scale)
      .def_ro("seconds", &ConsistentRanges::seconds)
      .def("__repr__", &ConsistentRanges::str);
  m.def(
      "consistent_ranges",
      [](const Graph& graph, double false_alarm, int window, double drift, double least_share, int proposals, int turns, double noise_scale,
         const std::vector<FactorId>& odometry) {
        const RangeConsistencyOptions options{false_alarm, window, drift, least_share, proposals, turns, noise_scale, odometry};
        return without_gil(graph, Values(), [&] { return consistent_ranges(graph, options); });
      },
      "graph"_a, "false_alarm"_a = 1e-3, "window"_a = 40, "drift"_a = 2.0, "least_share"_a = 0.25, "proposals"_a = 400, "turns"_a = 24,
      "noise_scale"_a = 0.0, "odometry"_a = std::vector<FactorId>(),
      "ranges that agree with each other; see holdfast/solvers/range_consistency.hpp");
  m.def(
      "agreeing_loops",
      [](const Graph& graph, const Values& values, const std::vector<FactorId>& loops, double false_alarm) {
        return without_gil(graph, values, [&] { return agreeing_loops(graph, values, loops, false_alarm); });
      },
      "graph"_a, "values"_a, "loops"_a, "false_alarm"_a = 0.01, "those of these loops that agree with an answer found without them");
}

}  // namespace

void bind_robust(nb::module_& m) {
  bind_gnc(m);
  bind_certificate(m);
  bind_consistency(m);
}

}  // namespace holdfast::python
