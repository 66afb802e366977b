// Back-ends, their options, and how a solve goes and ends.
#include <holdfast/solvers/gnc.hpp>
#include <holdfast/solvers/irls/irls.hpp>
#include <holdfast/solvers/table.hpp>

#include "bind.hpp"

namespace holdfast::python {
namespace {

using Progress = decltype(Options::progress);

/// A function given back to Python as what it is.
struct PythonProgress {
  std::shared_ptr<nb::object> function;
  bool operator()(const Iteration& iteration) const {
    const nb::gil_scoped_acquire gil;
    const nb::object answer = (*function)(iteration);
    return answer.is_none() || nb::cast<bool>(nb::module_::import_("operator").attr("truth")(answer));
  }
};

Progress progress_of(nb::object function) {
  if (function.is_none()) return nullptr;
  return PythonProgress{held(std::move(function))};
}

nb::object function_of(const Progress& progress) {
  const PythonProgress* python = progress.target<PythonProgress>();
  return python == nullptr ? nb::none() : *python->function;
}

// What holds a progress function, which may hold it in turn: Python's collector has to see that.
Progress& progress_in(Options& options) { return options.progress; }
Progress& progress_in(Backend& backend) { return backend.options.progress; }

template <class T>
int traverse(PyObject* self, visitproc visit, void* arg) {
  Py_VISIT(Py_TYPE(self));
  if (!nb::inst_ready(self)) return 0;
  const PythonProgress* python = progress_in(*nb::inst_ptr<T>(self)).template target<PythonProgress>();
  // There is one Python reference, however many copies share it: where they do, it is not this one's to give.
  if (python != nullptr && python->function.use_count() == 1) Py_VISIT(python->function->ptr());
  return 0;
}
template <class T>
int clear(PyObject* self) {
  if (nb::inst_ready(self)) progress_in(*nb::inst_ptr<T>(self)) = nullptr;
  return 0;
}
template <class T>
PyType_Slot slots[] = {
    {Py_tp_traverse, reinterpret_cast<void*>(traverse<T>)}, {Py_tp_clear, reinterpret_cast<void*>(clear<T>)}, {0, nullptr}};

/// Lets other Python threads run, and Ctrl-C stop it: KeyboardInterrupt, the values as they were.
Summary solve(Backend& backend, const Graph& graph, Values& values) {
  const Writing held_backend(&backend, "back-end");
  const Writing held_values(&values, "Values");
  const Reading held_graph(&graph, "Graph");
  const Progress asked = backend.options.progress;
  struct Restore {
    Backend& backend;
    const Progress& progress;
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

constexpr const char* kReweightings[] = {"automatic", "irls", "newton"};

Reweighting reweighting_named(const std::string& name) {
  for (int i = 0; i < 3; ++i)
    if (name == kReweightings[i]) return static_cast<Reweighting>(i);
  fail<BadOption>("reweighting = '", name, "', must be automatic, irls or newton");
}

std::unique_ptr<Backend> make(const std::string& name, const Options& options, const IrlsOptions& of_irls) {
  options.validate();
  if (name == "irls") return std::make_unique<Irls>(options, of_irls);
  if (name == "gnc-irls") return gnc(std::make_unique<Irls>(options, of_irls));
  if (of_irls.reweighting != Reweighting::automatic || !of_irls.restart)
    fail<BadOption>("reweighting and restart are options of irls and gnc-irls, not of '", name, "'");
  return make_backend(name, options);
}

IrlsOptions of_irls(const Backend& backend) {
  const auto* irls = dynamic_cast<const Irls*>(&backend);
  return irls == nullptr ? IrlsOptions{} : irls->irls_options;
}

nb::tuple state_of(const Options& o) {
  if (o.progress) fail<BadOption>("options with a progress function cannot be pickled; set progress to None");
  return nb::make_tuple(o.max_iterations, o.cost_tolerance, o.gradient_tolerance, o.threads, o.time_limit, o.second_order, o.findings,
                        o.trace);
}

using OptionsState = std::tuple<int, double, double, int, double, bool, bool, bool>;

Options options_from(const OptionsState& state) {
  Options o;
  std::tie(o.max_iterations, o.cost_tolerance, o.gradient_tolerance, o.threads, o.time_limit, o.second_order, o.findings, o.trace) = state;
  return o;
}

template <class T, class C>
void def_option(nb::class_<C>& c, const char* name, T C::*member, const char* doc) {
  c.def_prop_rw(
      name, [member](const C& options) { return options.*member; },
      [member](C& options, const T& value) {
        C changed = options;
        changed.*member = value;
        changed.validate();
        options = changed;
      },
      doc);
}

void bind_summary(nb::module_& m) {
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
}

void bind_options(nb::module_& m) {
  nb::class_<Iteration>(m, "Iteration")
      .def_ro("number", &Iteration::number, "0: the start")
      .def_ro("cost", &Iteration::cost)
      .def_ro("gradient_norm", &Iteration::gradient_norm)
      .def_ro("seconds", &Iteration::seconds);
  nb::class_<Options> options(m, "Options", nb::type_slots(slots<Options>),
                              "What every back-end can be asked for; see holdfast/solvers/options.hpp.");
  options.def(nb::init<>());
  def_option(options, "max_iterations", &Options::max_iterations, "0: the back-end's own");
  def_option(options, "cost_tolerance", &Options::cost_tolerance, "a step that lowers the cost by less than this part of it is the last");
  def_option(options, "gradient_tolerance", &Options::gradient_tolerance, "the largest component of the gradient");
  def_option(options, "threads", &Options::threads, "1 … 1024");
  def_option(options, "time_limit", &Options::time_limit, "[s]");
  def_option(options, "second_order", &Options::second_order, "leave saddles");
  def_option(options, "findings", &Options::findings, "check() at the answer");
  def_option(options, "trace", &Options::trace, "keep every iteration");
  options.def_prop_rw(
      "progress", [](const Options& o) { return function_of(o.progress); },
      [](Options& o, nb::object function) { o.progress = progress_of(std::move(function)); }, nb::arg().none(),
      "progress(iteration): called after each iteration; False stops the solve, what it raises ends it");
  options.def("__getstate__", &state_of).def("__setstate__", [](Options& o, const OptionsState& state) {
    new (&o) Options(options_from(state));
    o.validate();
  });
}

}  // namespace

std::unique_ptr<Backend> copy_of(const Backend& backend) {
  if (const auto* graduated = dynamic_cast<const Gnc*>(&backend)) {
    Backend& inner = const_cast<Gnc*>(graduated)->near_answer();
    std::unique_ptr<Backend> copy = gnc(copy_of(inner), graduated->gnc_options);
    copy->options = backend.options;
    return copy;
  }
  return make(backend.name(), backend.options, of_irls(backend));
}

void bind_backends(nb::module_& m) {
  nb::exception<BadProblem>(m, "BadProblem", m.attr("Error").ptr());
  bind_summary(m);
  bind_options(m);
  nb::class_<Backend>(m, "Backend", nb::type_slots(slots<Backend>))
      .def_prop_ro("name", &Backend::name)
      .def_prop_rw(
          "options", [](const Backend& backend) { return backend.options; },
          [](Backend& backend, const Options& options) {
            require_unused(&backend, "back-end");
            options.validate();
            backend.options = options;
          },
          "a copy; give it back to change it")
      .def("solve", &solve, "graph"_a, "values"_a,
           "values: start in, answer out; as they were where it fails. Other threads run meanwhile: they may read the graph; what would "
           "change it, or the values, is refused")
      .def(
          "__copy__", [](const Backend& backend) { return copy_of(backend).release(); }, nb::rv_policy::take_ownership)
      .def(
          "__deepcopy__", [](const Backend& backend, nb::handle) { return copy_of(backend).release(); }, nb::rv_policy::take_ownership)
      .def("__repr__", [](const Backend& backend) { return "Backend " + backend.name(); });
  m.def("backend_names", &backend_names);
  m.def(
      "make_backend",
      [](const std::string& name, int max_iterations, double cost_tolerance, double gradient_tolerance, int threads, double time_limit,
         bool second_order, bool findings, bool trace, nb::object progress, const std::string& reweighting, bool restart) {
        Options options{max_iterations, cost_tolerance, gradient_tolerance,
                        threads,        time_limit,     second_order,
                        findings,       trace,          progress_of(std::move(progress))};
        return make(name, options, {reweighting_named(reweighting), restart}).release();
      },
      "name"_a = "irls", "max_iterations"_a = 0, "cost_tolerance"_a = 1e-6, "gradient_tolerance"_a = 1e-10, "threads"_a = 1,
      "time_limit"_a = std::numeric_limits<double>::infinity(), "second_order"_a = false, "findings"_a = false, "trace"_a = false,
      "progress"_a = nb::none(), "reweighting"_a = "automatic", "restart"_a = true, nb::rv_policy::take_ownership,
      "'gnc-irls' is irls in graduated non-convexity, and so with every name. progress(iteration) is called after each iteration: False "
      "stops the solve. reweighting (automatic, irls, newton) and restart are of irls alone");
}

}  // namespace holdfast::python
