#include <holdfast/adapters/files/problem.hpp>
#include <holdfast/graph/files/files.hpp>
#include <holdfast/solvers/marginals.hpp>
#include <holdfast/solvers/outlier_report.hpp>
#include <holdfast/solvers/table.hpp>
#include <set>

#include "bind.hpp"

namespace holdfast::python {
namespace {

using Square = Eigen::Map<const Eigen::MatrixXd>;

Eigen::MatrixXd square(const std::vector<double>& numbers) {
  const auto n = static_cast<Eigen::Index>(std::lround(std::sqrt(static_cast<double>(numbers.size()))));
  return Square(numbers.data(), n, n);
}

/// Back-ends and values that some thread solves with: asked for and changed under the GIL alone.
std::set<const void*>& busy() {
  static std::set<const void*> all;
  return all;
}

/// Holds one of them for as long as it lives; BadProblem where another thread has it.
class Held {
 public:
  Held(const void* what, const char* name) : what_(what) {
    if (!busy().insert(what).second) fail<BadProblem>("another thread is solving with this ", name, "; give each thread its own");
  }
  Held(const Held&) = delete;
  Held& operator=(const Held&) = delete;
  ~Held() { busy().erase(what_); }

 private:
  const void* what_;
};

/// Lets other Python threads run, and Ctrl-C stop it: KeyboardInterrupt, the values as they were.
Summary solve(Backend& backend, const Graph& graph, Values& values) {
  const Held held_backend(&backend, "back-end");
  const Held held_values(&values, "Values");
  const auto asked = backend.options.progress;
  struct Restore {
    Backend& backend;
    decltype(asked)& progress;
    ~Restore() { backend.options.progress = progress; }
  } restore{backend, asked};
  backend.options.progress = [&asked](const Iteration& iteration) {
    {
      const nb::gil_scoped_acquire gil;
      if (PyErr_CheckSignals() != 0) throw nb::python_error();
    }
    return !asked || asked(iteration);
  };
  Summary summary = [&] {
    const nb::gil_scoped_release release;
    return backend.solve(graph, values);
  }();
  raise_interrupt();
  return summary;
}

}  // namespace

void bind_solvers(nb::module_& m) {
  const nb::object base = m.attr("Error");
  nb::exception<BadProblem>(m, "BadProblem", base.ptr());
  nb::exception<UnobservableError>(m, "UnobservableError", base.ptr());

  nb::class_<Summary>(m, "Summary")
      .def_prop_ro("termination", [](const Summary& s) { return std::string(to_string(s.termination)); })
      .def_prop_ro("usable", &Summary::usable, "values hold an answer no worse than the start")
      .def_prop_ro("why", &Summary::why)
      .def_ro("cost_first", &Summary::cost_first)
      .def_ro("cost", &Summary::cost)
      .def_ro("gradient_norm", &Summary::gradient_norm)
      .def_ro("iterations", &Summary::iterations)
      .def_ro("seconds", &Summary::seconds)
      .def_ro("restarts", &Summary::restarts)
      .def_ro("is_convex", &Summary::is_convex, "every factor and loss is convex: what converged is the global minimum")
      .def_ro("decrement", &Summary::decrement, "of a convex problem what the cost lies above its minimum by, about; NaN where unknown")
      .def_prop_ro(
          "minimum", [](const Summary& s) { return std::string(to_string(s.minimum)); },
          "'second-order minimum', 'left a saddle', or 'not checked'")
      .def_ro("not_checked", &Summary::not_checked, "why, where it was not")
      .def_ro("saddles_left", &Summary::saddles_left)
      .def_ro("findings", &Summary::findings, "what check() finds at the answer, where asked for")
      .def_prop_ro(
          "trace",
          [](const Summary& s) {
            nb::list all;
            for (const Iteration& i : s.trace) all.append(nb::make_tuple(i.number, i.cost, i.gradient_norm, i.seconds));
            return all;
          },
          "(number, cost, gradient norm, seconds) of each iteration, where asked for")
      .def("__repr__", &Summary::str);
  nb::class_<Backend>(m, "Backend")
      .def_prop_ro("name", &Backend::name)
      .def("solve", &solve, "graph"_a, "values"_a,
           "values: start in, answer out; as they were where it "
           "fails. Other threads run meanwhile: they may read the "
           "graph, and must change neither graph nor values");
  m.def("backend_names", &backend_names);
  m.def(
      "make_backend",
      [](const std::string& name, int max_iterations, double cost_tolerance, double gradient_tolerance, int threads, double time_limit,
         bool second_order, bool findings, bool trace) {
        Options options;
        options.max_iterations = max_iterations;
        options.cost_tolerance = cost_tolerance;
        options.gradient_tolerance = gradient_tolerance;
        options.threads = threads;
        options.time_limit = time_limit;
        options.second_order = second_order;
        options.findings = findings;
        options.trace = trace;
        options.validate();
        return make_backend(name, options).release();
      },
      "name"_a = "irls", "max_iterations"_a = 0, "cost_tolerance"_a = 1e-6, "gradient_tolerance"_a = 1e-10, "threads"_a = 1,
      "time_limit"_a = std::numeric_limits<double>::infinity(), "second_order"_a = false, "findings"_a = false, "trace"_a = false,
      nb::rv_policy::take_ownership, "'gnc-irls' is irls in graduated non-convexity, and so with every name");

  nb::class_<Marginals>(m, "Marginals")
      .def(
          "__init__",
          [](Marginals* self, const Graph& graph, const Values& values) {
            new (self) Marginals(without_gil(graph, [&] { return Marginals(graph, values); }));
          },
          "graph"_a, "values"_a)
      .def(
          "covariance", [](const Marginals& c, Key key) { return square(c.covariance(key)); }, "key"_a)
      .def(
          "joint", [](const Marginals& c, Key a, Key b) { return square(c.joint(a, b)); }, "a"_a, "b"_a)
      .def("is_observable", &Marginals::is_observable, "key"_a)
      .def("unobservable", &Marginals::unobservable);

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
      [](const Graph& graph, const Values& values) { return without_gil(graph, [&] { return outlier_report(graph, values); }); }, "graph"_a,
      "values"_a, "which measurements the losses believe at these values");

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
}

}  // namespace holdfast::python
