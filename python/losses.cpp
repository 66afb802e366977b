// Losses by their names, as in C++: Huber(2), per_component(Cauchy(1)), one_sided(…).
#include <holdfast/graph/dynamic_covariance_scaling.hpp>
#include <holdfast/graph/max_mixture.hpp>
#include <holdfast/graph/switchable_constraint.hpp>

#include "own_loss.hpp"

namespace holdfast::python {
namespace {

template <class L>
void def_loss(nb::module_& m, const char* name, const char* parameter, double usual, const char* rho) {
  m.def(
      name, [](double threshold) { return Loss(L{threshold}); }, nb::arg(parameter) = usual, rho);
}

nb::tuple state_of(const Loss& loss) {
  if (loss.kind == Loss::Kind::Own && !loss.is_named())
    fail<BadOption>("the loss ", loss.str(), " has no name that a file could hold (register_loss)");
  const std::string name = loss.str();
  const double scale = loss.kind == Loss::Kind::Own ? *loss.own->scale() : loss.scale;
  return nb::make_tuple(name.substr(0, name.find(':')), scale, loss.per_component, loss.one_sided);
}

/// The very bits of the threshold, which a text need not give back.
Loss from_state(const nb::tuple& state) {
  Loss loss = Loss::parse(nb::cast<std::string>(state[0]));
  const double scale = nb::cast<double>(state[1]);
  if (loss.kind != Loss::Kind::Own)
    loss.scale = scale;
  else if (loss.own->type() == typeid(MaxMixture))
    loss = Loss(MaxMixture{scale});
  else
    loss = Loss(DynamicCovarianceScaling{scale});
  loss.per_component = nb::cast<bool>(state[2]);
  loss.one_sided = nb::cast<bool>(state[3]);
  return loss;
}

}  // namespace

void bind_losses(nb::module_& m) {
  register_loss<MaxMixture>();
  register_loss<DynamicCovarianceScaling>();
  register_loss<SwitchableConstraint>();
  nb::class_<Loss>(m, "Loss")
      .def(
          "__init__", [](Loss* loss, const std::string& text) { new (loss) Loss(Loss::parse(text)); }, "text"_a,
          "'huber:2', 'cauchy:1:component', 'truncated_squares:3:one_sided', …")
      .def_prop_ro("per_component", [](const Loss& loss) { return loss.per_component; })
      .def_prop_ro("one_sided", [](const Loss& loss) { return loss.one_sided; })
      .def_prop_ro("is_convex", &Loss::is_convex, "½ρ(r²) is a convex function of r")
      .def(
          "rho",
          [](const Loss& loss, double s, int d) {
            if (!(s >= 0)) fail<BadNumber>("rho(s): s = ", s, " is the square of a residual and must be >= 0");
            if (d < 1) fail<BadNumber>("rho(s, d): d = ", d, " components, must be >= 1");
            loss.validate(1);
            const Rho rho = loss.rho(s, d);
            return nb::make_tuple(rho.value, rho.first, rho.second);
          },
          "s"_a, "d"_a = 1, "(ρ, ρ', ρ'') at s, of a block of d components")
      .def("__eq__", [](const Loss& a, const Loss& b) { return a == b; })
      .def("__eq__", [](const Loss&, nb::handle) { return nb::borrow(Py_NotImplemented); })
      .def("__getstate__", &state_of)
      .def("__setstate__", [](Loss& loss, const nb::tuple& state) { new (&loss) Loss(from_state(state)); })
      .def("__repr__", &Loss::str);
  nb::implicitly_convertible<std::string, Loss>();

  m.def(
      "Squared", [] { return Loss(); }, "ρ = s");
  def_loss<Absolute>(m, "Absolute", "width", 1e-2, "ρ = 2(√(s + width²) − width)");
  def_loss<Huber>(m, "Huber", "a", 2, "ρ = s for √s ≤ a, else 2a√s − a²");
  def_loss<PseudoHuber>(m, "PseudoHuber", "a", 2, "ρ = 2a²(√(1 + s/a²) − 1)");
  def_loss<Cauchy>(m, "Cauchy", "c", 2, "ρ = c² ln(1 + s/c²)");
  def_loss<GemanMcClure>(m, "GemanMcClure", "c", 2, "ρ = c² s / (c² + s)");
  def_loss<Welsch>(m, "Welsch", "c", 3, "ρ = c² (1 − exp(−s/c²))");
  def_loss<Tukey>(m, "Tukey", "c", 4.685, "ρ = c²/3 (1 − (1 − s/c²)³) for √s ≤ c, else c²/3");
  def_loss<TruncatedSquares>(m, "TruncatedSquares", "c", 3.5, "ρ = min(s, c²)");
  def_loss<StudentT>(m, "StudentT", "nu", 3, "ρ = (ν + d) ln(1 + s/ν)");
  def_loss<MaxMixture>(m, "MaxMixture", "width", 10, "ρ = min(s, s/width² + constant)");
  def_loss<DynamicCovarianceScaling>(m, "DynamicCovarianceScaling", "c", 1, "ρ = s for s ≤ c², else c² (3s − c²) / (c² + s)");
  def_loss<SwitchableConstraint>(m, "SwitchableConstraint", "c", 1,
                                 "ρ = min over the switch ω of ω² s + c² (1 − ω)², which is that of GemanMcClure(c)");
  m.def(
      "per_component", [](Loss loss) { return per_component(std::move(loss)); }, "loss"_a, "each component is a block of its own");
  m.def(
      "one_sided", [](Loss loss) { return one_sided(std::move(loss)); }, "loss"_a, "squared where r > 0");
  bind_own_losses(m);
}

}  // namespace holdfast::python
