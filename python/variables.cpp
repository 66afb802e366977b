#include "bind.hpp"

namespace holdfast::python {
namespace {

template <class V>
nb::class_<V> bind_variable(nb::module_& m) {
  nb::class_<V> c(m, V::name());
  c.def(
      "retract", [](const V& x, nb::handle delta) { return x.retract(numbers<typename V::Tangent>("retract", delta)); }, "delta"_a,
      "x ⊕ δ");
  c.def("local", &V::local, "other"_a, "other ⊖ x: x.retract(x.local(y)) == y");
  c.def("__repr__", [](const V& x) { return printed(x); });
  c.def("__eq__", [](const V& a, const V& b) { return std::memcmp(&a, &b, sizeof(V)) == 0; });
  c.def("__eq__", [](const V&, nb::handle) { return nb::borrow(Py_NotImplemented); });
  c.def("__getstate__", [](const V& x) {
    const auto* p = reinterpret_cast<const double*>(&x);
    return std::vector<double>(p, p + ambient_dim<V>);
  });
  c.def("__setstate__", [](V& x, const std::vector<double>& state) {
    if (state.size() != ambient_dim<V>) fail<BadNumber>(V::name(), ": ", state.size(), " numbers, it has ", ambient_dim<V>);
    new (&x) V();
    std::memcpy(static_cast<void*>(&x), state.data(), sizeof(V));
  });
  c.attr("dim") = V::dim;
  c.attr("ambient") = ambient_dim<V>;
  if constexpr (space_dim < V >> 0)
    c.def_prop_ro(
        "position", [](const V& x) { return Vector<space_dim<V>>(x.position()); }, "in the world [m]");
  return c;
}

template <class V>
void bind_vector(nb::module_& m) {
  using Numbers = typename V::Tangent;
  auto c = bind_variable<V>(m);
  c.def("__init__", [](V* x, nb::args args) {
    if (args.size() == 0)
      new (x) V();
    else
      new (x) V(numbers<Numbers>(V::name(), args.size() == 1 ? nb::handle(args[0]) : nb::handle(args)));
  });
  c.def_prop_ro(
      "value", [](const V& x) { return Numbers(x.value); }, "a copy of its numbers [m, m/s, m/s²]");
}

}  // namespace

void bind_variables(nb::module_& m) {
  auto agent = nb::class_<Agent>(m, "Agent");
  auto key = nb::class_<Key>(m, "Key");
  agent
      .def(
          "__init__",
          [](Agent* a, const std::string& text, std::optional<std::uint64_t> number) {
            if (number && text.size() != 1) fail<BadKey>("an agent's kind is one character, not '", text, "'");
            new (a) Agent(number ? Agent(text[0], *number) : Agent::parse(text));
          },
          "kind"_a, "number"_a = nb::none())
      .def(
          "__call__", [](Agent a, std::uint64_t step) { return a(step); }, "step"_a)
      .def_prop_ro("number", &Agent::number)
      .def("__eq__", [](Agent a, Agent b) { return a == b; })
      .def("__hash__", [](Agent a) { return std::hash<Agent>()(a); })
      .def("__repr__", &Agent::str);
  key.def(
         "__init__", [](Key* k, const std::string& text) { new (k) Key(Key::parse(text)); }, "text"_a)
      .def_static("from_bits", &Key::from_bits, "bits"_a)
      .def_prop_ro("bits", &Key::bits)
      .def_prop_ro("step", &Key::step)
      .def_prop_ro("agent", &Key::agent)
      .def("__index__", &Key::bits)
      .def("__eq__", [](Key a, Key b) { return a == b; })
      .def("__lt__", [](Key a, Key b) { return a < b; })
      .def("__hash__", [](Key k) { return std::hash<Key>()(k); })
      .def("__getstate__", [](Key k) { return k.bits(); })
      .def("__setstate__", [](Key& k, std::uint64_t bits) { new (&k) Key(Key::from_bits(bits)); })
      .def("__repr__", &Key::str);
  nb::implicitly_convertible<std::string, Key>();

  bind_vector<Point2>(m);
  bind_vector<Point3>(m);
  bind_vector<Motion2>(m);
  bind_vector<Motion3>(m);
  bind_vector<Accel2>(m);
  bind_vector<Accel3>(m);
  bind_vector<Turning2>(m);
  bind_variable<Scalar>(m).def(nb::init<double>(), "value"_a = 0.0).def_prop_ro("value", [](const Scalar& x) { return x.value; });
  bind_variable<Pose2>(m)
      .def(nb::init<double, double, double>(), "x"_a = 0.0, "y"_a = 0.0, "theta"_a = 0.0)
      .def_prop_ro(
          "p", [](const Pose2& x) { return x.p; }, "p_world [m]")
      .def_prop_ro("angle", &Pose2::angle, "[rad]")
      .def("inverse", &Pose2::inverse)
      .def("__mul__", [](const Pose2& a, const Pose2& b) { return a * b; });
  bind_variable<Pose3>(m)
      .def(
          "__init__",
          [](Pose3* x, nb::handle position, nb::handle quaternion) {
            const auto p = numbers<Vector<3>>("Pose3.p", position);
            const auto q = numbers<Vector<4>>("Pose3.q", quaternion);
            if (!(std::abs(q.norm() - 1) < 1e-6)) fail<BadNumber>("Pose3: the quaternion (x, y, z, w) has length ", q.norm(), ", not 1");
            new (x) Pose3(p, Pose3::Rotation(q[3], q[0], q[1], q[2]).normalized());
          },
          "p"_a, "q"_a, "p_world [m] and the quaternion (x, y, z, w)")
      .def("__init__", [](Pose3* x) { new (x) Pose3(); })
      .def_static(
          "from_roll_pitch_yaw",
          [](nb::handle p, double roll, double pitch, double yaw) {
            return Pose3::from_roll_pitch_yaw(numbers<Vector<3>>("Pose3.p", p), roll, pitch, yaw);
          },
          "p"_a, "roll"_a, "pitch"_a, "yaw"_a)
      .def_prop_ro(
          "p", [](const Pose3& x) { return x.p; }, "p_world [m]")
      .def_prop_ro(
          "q", [](const Pose3& x) { return Vector<4>(x.q.coeffs()); }, "x, y, z, w")
      .def("roll_pitch_yaw", &Pose3::roll_pitch_yaw)
      .def("inverse", &Pose3::inverse)
      .def("__mul__", [](const Pose3& a, const Pose3& b) { return a * b; });
}

}  // namespace holdfast::python
