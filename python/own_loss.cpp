// A loss in Python: a function of s, or an object with rho(s), as Loss::own.
#include "own_loss.hpp"

#include <cmath>
#include <holdfast/graph/detail/evaluation_error.hpp>
#include <limits>
#include <mutex>

namespace holdfast::python {
namespace {

/// Losses share a batch by their C++ type, and all of a batch are convex or none is.
template <bool convex>
class PythonLoss final : public detail::OwnLoss, public detail::FallibleLoss {
 public:
  PythonLoss(std::shared_ptr<nb::object> rho, const void* identity, std::string name)
      : rho_(std::move(rho)), identity_(identity), name_(std::move(name)) {}

  std::type_index type() const override { return typeid(PythonLoss); }
  Rho rho(double s, int) const override {
    const nb::gil_scoped_acquire gil;
    try {
      const nb::object result = (*rho_)(s);
      const nb::tuple three = nb::steal<nb::tuple>(PySequence_Tuple(result.ptr()));
      if (!three.is_valid()) throw nb::python_error();
      if (nb::len(three) != 3)
        throw nb::value_error(("rho(s) returns ρ, ρ' and ρ'': 3 numbers, not " + std::to_string(nb::len(three))).c_str());
      return {nb::cast<double>(nb::float_(three[0])), nb::cast<double>(nb::float_(three[1])), nb::cast<double>(nb::float_(three[2]))};
    } catch (const std::exception& error) {
      note_interrupt(error);
      const std::string text = error.what();
      const std::lock_guard<std::mutex> lock(mutex_);
      if (error_.empty()) error_ = text;
      const double nan = std::numeric_limits<double>::quiet_NaN();
      return {nan, nan, nan};
    }
  }
  bool is_convex() const override { return convex; }
  Loss relaxed() const override { return detail::huber_up_to_bend(*this); }
  void validate() const override {}
  bool equals(const OwnLoss& other) const override { return identity_ == static_cast<const PythonLoss&>(other).identity_; }
  std::string name() const override { return name_; }
  const double* scale() const override { return nullptr; }
  std::string take_error() const override {
    const std::lock_guard<std::mutex> lock(mutex_);
    return std::exchange(error_, std::string());
  }

 private:
  std::shared_ptr<nb::object> rho_;
  const void* identity_;
  std::string name_;
  mutable std::mutex mutex_;
  mutable std::string error_;
};

std::string name_of(const nb::object& given, bool has_rho) {
  if (nb::hasattr(given, "name")) return nb::cast<std::string>(given.attr("name"));
  const nb::handle named = has_rho ? given.type() : nb::handle(given);
  return nb::hasattr(named, "__name__") ? nb::cast<std::string>(named.attr("__name__")) : "Loss";
}

/// The rule of the contract that the loss breaks, in words; "": none. A concave ρ rises between a and b by (b − a) ρ'(b) to (b − a) ρ'(a).
std::string broken_rule(const detail::OwnLoss& loss) {
  std::ostringstream broken;
  Rho before = loss.rho(0, 1);
  if (before.value != 0)
    broken << "rho(0) = " << before.value << ", not 0";
  else if (std::abs(before.first - 1) > 1e-6)
    broken << "rho'(0) = " << before.first << ", not 1";
  double a = 0;
  for (double b = 1e-6; b < 1e6 && broken.str().empty(); a = b, b *= 1.07) {  // both sides of any threshold in sigmas
    const Rho rho = loss.rho(b, 1);
    const double step = b - a, rise = rho.value - before.value, rounding = 1e-9 * (std::abs(rho.value) + step);
    if (!std::isfinite(rho.value) || !std::isfinite(rho.first) || !std::isfinite(rho.second))
      broken << "at s = " << b << " it is not finite";
    else if (rho.first < 0)
      broken << "rho'(" << b << ") = " << rho.first << " is negative";
    else if (rho.second > 1e-9)
      broken << "rho''(" << b << ") = " << rho.second << " is positive: it is not concave";
    else if (rise > before.first * step + rounding || rise < rho.first * step - rounding)
      broken << "between s = " << a << " and " << b << " it rises by " << rise
             << ", which is not what a concave rho with rho' = " << before.first << " and " << rho.first << " there rises by";
    before = rho;
  }
  return broken.str();
}

Loss own_loss(const nb::object& given, std::optional<std::string> name, std::optional<bool> is_convex, bool check) {
  const bool has_rho = nb::hasattr(given, "rho");
  if (!name) name = name_of(given, has_rho);
  if (!is_convex) is_convex = nb::hasattr(given, "is_convex") && nb::cast<bool>(given.attr("is_convex"));
  const std::shared_ptr<nb::object> rho = held(has_rho ? nb::object(given.attr("rho")) : given);
  Loss loss;
  loss.kind = Loss::Kind::Own;
  if (*is_convex)
    loss.own = std::make_shared<PythonLoss<true>>(rho, given.ptr(), *name);
  else
    loss.own = std::make_shared<PythonLoss<false>>(rho, given.ptr(), *name);
  if (!check) return loss;
  const std::string broken = broken_rule(*loss.own);
  const std::string raised = dynamic_cast<const detail::FallibleLoss&>(*loss.own).take_error();
  raise_interrupt();
  if (!raised.empty()) throw std::runtime_error("loss " + *name + ": " + raised);
  if (!broken.empty())
    fail<BadNumber>("loss ", *name, " breaks the contract of losses (docs/losses.md): ", broken, "; check=False takes it as it is");
  return loss;
}

}  // namespace

void bind_own_losses(nb::module_& m) {
  m.def("own_loss", &own_loss, "function"_a, "name"_a = nb::none(), "is_convex"_a = nb::none(), "check"_a = true,
        R"(A loss of your own: a function of s = ‖r‖² that returns (ρ, ρ', ρ''), or an object with such a method rho(s).

The contract is that of every loss: ρ(0) = 0, ρ'(0) = 1, ρ' ≥ 0, ρ concave in s; with check=True it is tried at 400 values of s, and
BadNumber says what breaks it. is_convex: ½ρ(r²) is a convex function of r. name, for messages. Both may be attributes of the object.

It goes wherever a loss goes: per_component, one_sided, gnc, every back-end. It is called once a factor and evaluation, under the GIL:
a microsecond or so each. Two are equal where they are of the same Python object. What it raises ends a solve as 'failed', with the message
in Summary.why, and the values stay as they were. It cannot be pickled or saved.)");
}

}  // namespace holdfast::python
