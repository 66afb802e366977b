#include <holdfast/graph/check.hpp>
#include <holdfast/graph/files/binary.hpp>
#include <holdfast/graph/print.hpp>

#include "bind.hpp"

namespace holdfast::python {
namespace {

Graph& unused(Graph& graph) {
  require_unused(&graph, "Graph");
  return graph;
}
Values& unused(Values& values) {
  require_unused(&values, "Values");
  return values;
}

template <class... V>
struct Types {};
using Variables = Types<Point2, Point3, Motion2, Motion3, Accel2, Accel3, Turning2, Scalar, Pose2, Pose3>;

template <class... V>
nb::object value_at(const Values& values, Key key, Types<V...>) {
  nb::object found;
  (void)((values.contains<V>(key) && (found = nb::cast(values.at<V>(key)), true)) || ...);
  if (!found.is_valid()) values.slot(key);  // throws BadKey
  return found;
}

template <class... V>
void bind_values(nb::class_<Values>& c, Types<V...> types) {
  (c.def(
       "insert", [](Values& values, Key key, const V& x) { unused(values).insert(key, x); }, "key"_a, "value"_a),
   ...);
  (c.def(
       "update", [](Values& values, Key key, const V& x) { unused(values).update(key, x); }, "key"_a, "value"_a),
   ...);
  c.def(
      "__getitem__", [types](const Values& values, Key key) { return value_at(values, key, types); }, "key"_a);
}

template <class E, class Base>
nb::object error(nb::module_& m, const char* name, const Base& base) {
  return nb::exception<E>(m, name, base.ptr());
}

/// For pickle: the library's own file, which brings back every bit and every FactorId (graph/files/binary.hpp).
nb::bytes to_bytes(const Graph& graph, const Values& values) {
  io::ByteWriter out;
  io::write_binary(out, graph, values);
  return nb::bytes(out.bytes().data(), out.bytes().size());
}

std::pair<Graph, Values> from_bytes(const nb::bytes& bytes) {
  std::pair<Graph, Values> both;
  io::ByteReader in(std::string_view(bytes.c_str(), bytes.size()));
  io::read_binary(in, both.first, both.second);
  if (!in.at_end()) fail<BadFile>("a pickled graph or values with more bytes than it has");
  return both;
}

}  // namespace

Key key_of(nb::handle given) {
  if (nb::isinstance<Key>(given)) return nb::cast<Key>(given);
  if (nb::isinstance<nb::str>(given)) return Key::parse(nb::cast<std::string>(given));
  std::uint64_t bits = 0;
  const nb::object number = nb::steal(PyNumber_Index(given.ptr()));
  if (number.is_valid() && nb::try_cast(number, bits)) return Key::from_bits(bits);
  PyErr_Clear();
  throw nb::type_error(("a key is a Key, its text or its bits, not " + nb::cast<std::string>(nb::repr(given))).c_str());
}

Agent agent_of(nb::handle given) {
  if (nb::isinstance<Agent>(given)) return nb::cast<Agent>(given);
  if (nb::isinstance<nb::str>(given)) return Agent::parse(nb::cast<std::string>(given));
  throw nb::type_error(("an agent is an Agent or its text, not " + nb::cast<std::string>(nb::repr(given))).c_str());
}

void bind_graph(nb::module_& m) {
  const nb::object base = nb::exception<Error>(m, "Error", PyExc_RuntimeError);
  error<BadNumber>(m, "BadNumber", base);
  error<BadKey>(m, "BadKey", base);
  error<BadType>(m, "BadType", base);
  error<BadOption>(m, "BadOption", base);
  error<BadFile>(m, "BadFile", base);

  bind_losses(m);

  nb::class_<Values> values(m, "Values");
  values.def(nb::init<>())
      .def(
          "__init__", [](Values* to, const Values& from) { new (to) Values(from); }, "other"_a)
      .def(
          "erase", [](Values& v, Key key) { unused(v).erase(key); }, "key"_a)
      .def("keys", &Values::keys, "sorted")
      .def(
          "__iter__", [](const Values& v) { return nb::iter(nb::cast(v.keys())); }, "over the keys, sorted")
      .def("__contains__", [](const Values& v, Key key) { return v.contains(key); })
      .def("__len__", &Values::size)
      .def("__getstate__", [](const Values& v) { return to_bytes(Graph(), v); })
      .def("__setstate__",
           [](Values& v, const nb::bytes& bytes) {
             auto [graph, values] = from_bytes(bytes);
             new (&v) Values(std::move(values));
           })
      .def("__repr__", [](const Values& v) { return printed(v); });
  bind_values(values, Variables());

  nb::class_<FactorId>(m, "FactorId")
      .def_ro("number", &FactorId::number)
      .def("__eq__", [](FactorId a, FactorId b) { return a.number == b.number && a.generation == b.generation; })
      .def("__eq__", [](FactorId, nb::handle) { return nb::borrow(Py_NotImplemented); })
      .def("__hash__", [](FactorId id) { return std::hash<std::uint64_t>()((std::uint64_t{id.generation} << 32) + id.number); })
      .def("__getstate__", [](FactorId id) { return nb::make_tuple(id.number, id.generation); })
      .def("__setstate__",
           [](FactorId& id, const std::tuple<int, unsigned>& state) {
             new (&id) FactorId{std::get<0>(state), std::get<1>(state)};
           })
      .def("__repr__", [](FactorId id) { return "FactorId(" + std::to_string(id.number) + ")"; });
  nb::class_<Graph> graph(m, "Graph", nb::type_slots(graph_slots));
  graph.def(nb::init<>())
      .def(
          "__init__", [](Graph* to, const Graph& from) { new (to) Graph(from); }, "other"_a)
      .def(
          "remove", [](Graph& g, FactorId id) { unused(g).remove(id); }, "id"_a)
      .def("__contains__", &Graph::contains)
      .def(
          "fix", [](Graph& g, Key key) { unused(g).fix(key); }, "key"_a, "a fixed variable is a constant of the problem")
      .def(
          "unfix", [](Graph& g, Key key) { unused(g).unfix(key); }, "key"_a)
      .def("is_fixed", &Graph::is_fixed, "key"_a)
      .def(
          "set_weight", [](Graph& g, FactorId id, double weight) { unused(g).set_weight(id, weight); }, "id"_a, "weight"_a)
      .def(
          "set_loss", [](Graph& g, FactorId id, const Loss& loss) { unused(g).set_loss(id, loss); }, "id"_a, "loss"_a)
      .def(
          "cost", [](const Graph& g, const Values& values) { return without_gil(g, values, [&] { return g.cost(values); }); }, "values"_a,
          "Σ w ½ρ at these values")
      .def(
          "residual",
          [](const Graph& g, FactorId id, const Values& values) { return without_gil(g, values, [&] { return g.residual(id, values); }); },
          "id"_a, "values"_a, "whitened")
      .def("factors_on", &Graph::factors_on, "key"_a)
      .def("__len__", &Graph::size)
      .def("__getstate__", [](const Graph& g) { return to_bytes(g, Values()); })
      .def("__setstate__",
           [](Graph& g, const nb::bytes& bytes) {
             auto [graph, values] = from_bytes(bytes);
             new (&g) Graph(std::move(graph));
           })
      .def("__repr__", [](const Graph& g) { return printed(g); });
  bind_functions(graph);

  nb::class_<Finding>(m, "Finding")
      .def_ro("text", &Finding::text)
      .def_ro("keys", &Finding::keys)
      .def_prop_ro("kind", [](const Finding& f) { return std::string(to_string(f.kind)); })
      .def_prop_ro("is_error", [](const Finding& f) { return f.severity == Finding::Severity::error; })
      .def("__repr__", [](const Finding& f) { return f.text; });
  m.def("merged", &merged, "findings"_a, "findings that say the same of many keys as one");
  m.def(
      "check", [](const Graph& graph, const Values& values) { return without_gil(graph, values, [&] { return check(graph, values); }); },
      "graph"_a, "values"_a, "what is wrong with a problem, by name");
}

}  // namespace holdfast::python
