// Every factor by one template over its fields (graph/fields.hpp): a new factor is one line at the end.
#include <holdfast/factors/antenna_range.hpp>
#include <holdfast/factors/between.hpp>
#include <holdfast/factors/constant_turn.hpp>
#include <holdfast/factors/coordinated_turn.hpp>
#include <holdfast/factors/missing_distance.hpp>
#include <holdfast/factors/position_step.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/factors/range_bearing.hpp>
#include <holdfast/factors/relative_point.hpp>
#include <holdfast/factors/von_mises_bearing.hpp>
#include <holdfast/factors/white_acceleration.hpp>
#include <holdfast/factors/white_jerk.hpp>

#include "bind.hpp"

namespace holdfast::python {
namespace {

template <class F, class = void>
struct HasFromSigmas : std::false_type {};
template <class F>
struct HasFromSigmas<F, std::void_t<decltype(&F::from_sigmas)>> : std::true_type {};

/// What a field is in Python: an enum is its number.
template <class T>
using InPython = std::conditional_t<std::is_enum_v<T>, int, T>;

template <class T>
T from_python(const char* what, nb::handle given) {
  if constexpr (detail::IsFixedMatrix<T>::value)
    return numbers<T>(what, given);
  else
    return static_cast<T>(nb::cast<InPython<T>>(given));
}

/// What from_sigmas() takes first: its first field.
template <class F>
auto measured_as(nb::handle given) {
  constexpr auto first = std::get<0>(F::fields());
  using T = typename std::decay_t<decltype(first)>::type;
  try {
    return from_python<T>(first.name, given);
  } catch (const std::bad_cast&) {
    throw nb::type_error(
        (std::string(F::name()) + "." + first.name + " is a " + detail::field_type<T>() + ", not " + nb::cast<std::string>(nb::repr(given)))
            .c_str());
  }
}

/// The fields in order, from positions and names. Every one must be given, and nothing else.
template <class F>
F from_arguments(const nb::args& args, const nb::kwargs& named) {
  F factor{};
  std::size_t i = 0, taken = 0;
  std::apply(
      [&](const auto&... f) {
        const auto take = [&](const auto& one) {
          using T = std::decay_t<decltype(factor.*one.member)>;
          nb::object given;
          if (i < args.size()) {
            given = args[i];
          } else if (named.contains(one.name)) {
            given = named[one.name];
            ++taken;
          } else {
            throw nb::type_error((std::string(F::name()) + ": the argument '" + one.name + "' is missing").c_str());
          }
          ++i;
          try {
            factor.*one.member = from_python<T>(one.name, given);
          } catch (const std::bad_cast&) {
            throw nb::type_error((std::string(F::name()) + "." + one.name + " is a " + detail::field_type<T>() + ", not " +
                                  nb::cast<std::string>(nb::repr(given)))
                                     .c_str());
          }
        };
        (take(f), ...);
      },
      F::fields());
  if (args.size() > i || taken != named.size())
    throw nb::type_error((std::string(F::name()) + " takes {" + detail::types_of_fields<F>() + "}; there are more arguments").c_str());
  return factor;
}

template <class F>
FactorKeys<F::Variables::size> keys_of(const std::vector<Key>& keys) {
  constexpr std::size_t n = F::Variables::size;
  if (keys.size() != n) fail<BadKey>(F::name(), " ties ", n, " variables, and ", keys.size(), " keys are given");
  std::array<Key, n> all;
  std::copy(keys.begin(), keys.end(), all.begin());
  return all;
}

template <class F>
FactorId add(Graph& graph, const F& factor, const FactorKeys<F::Variables::size>& keys, const std::optional<Loss>& loss,
             std::optional<double> weight) {
  if (!loss && !weight) return graph.add(factor, keys);
  if (!weight) return graph.add(factor, keys, *loss);
  if (loss) return graph.add(factor, keys, *loss, *weight);
  if constexpr (detail::HasDefaultLoss<F>::value)
    return graph.add(factor, keys, F::default_loss(), *weight);
  else
    return graph.add(factor, keys, Loss{}, *weight);
}

template <class F, std::size_t... I>
std::string name_of(std::index_sequence<I...>) {
  return F::name() + (std::string() + ... + (std::string("_") + F::Variables::template type<I>::name()));
}

/// Range_Pose2_Point2, which holdfast/__init__.py gives as Range[Pose2, Point2].
template <class F>
void bind_factor(nb::module_& m) {
  const std::string name = name_of<F>(std::make_index_sequence<F::Variables::size>());
  nb::class_<F> c(m, name.c_str());
  c.def("__init__", [](F* self, const nb::args& args, const nb::kwargs& named) { new (self) F(from_arguments<F>(args, named)); });
  std::apply(
      [&](const auto&... f) {
        (c.def_prop_ro(f.name,
                       [f](const F& factor) {
                         using T = std::decay_t<decltype(factor.*f.member)>;
                         return static_cast<InPython<T>>(factor.*f.member);
                       }),
         ...);
      },
      F::fields());
  if constexpr (HasFromSigmas<F>::value) {
    constexpr int n = F::residual_dim;
    c.def_static(
        "from_sigmas",
        [](nb::handle measured, nb::handle sigmas) {
          return F::from_sigmas(measured_as<F>(measured), numbers<Vector<n>>("sigmas", sigmas));
        },
        "measured"_a, "sigmas"_a);
    c.def_static(
        "from_covariance",
        [](nb::handle measured, nb::handle covariance) {
          return F::from_covariance(measured_as<F>(measured), numbers<Matrix<n, n>>("covariance", covariance));
        },
        "measured"_a, "covariance"_a);
    c.def_static(
        "from_information",
        [](nb::handle measured, nb::handle information) {
          return F::from_information(measured_as<F>(measured), numbers<Matrix<n, n>>("information", information));
        },
        "measured"_a, "information"_a);
  }
  c.def("__repr__", [name](const F&) { return name; });
  c.def(
      "_add",
      [](const F& factor, Graph& graph, const std::vector<Key>& keys, const std::optional<Loss>& loss, std::optional<double> weight) {
        return add(graph, factor, keys_of<F>(keys), loss, weight);
      },
      "graph"_a, "keys"_a, "loss"_a.none(), "weight"_a.none());
  c.attr("fields") = detail::types_of_fields<F>();
}

}  // namespace

void bind_factors(nb::module_& m) {
  bind_factor<Prior<Point2>>(m);
  bind_factor<Prior<Point3>>(m);
  bind_factor<Prior<Pose2>>(m);
  bind_factor<Prior<Pose3>>(m);
  bind_factor<Prior<Motion2>>(m);
  bind_factor<Prior<Motion3>>(m);
  bind_factor<Prior<Scalar>>(m);
  bind_factor<Between<Pose2>>(m);
  bind_factor<Between<Pose3>>(m);
  bind_factor<Range<Pose2, Point2>>(m);
  bind_factor<Range<Pose2, Pose2>>(m);
  bind_factor<Range<Point2, Point2>>(m);
  bind_factor<Range<Motion2, Point2>>(m);
  bind_factor<Range<Pose3, Point3>>(m);
  bind_factor<Range<Pose3, Pose3>>(m);
  bind_factor<Range<Point3, Point3>>(m);
  bind_factor<RangeBall<Point2, Point2>>(m);
  bind_factor<RangeBall<Point3, Point3>>(m);
  bind_factor<AntennaRange<Pose3, Point3>>(m);
  bind_factor<RangeBearing<Point2, Point2>>(m);
  bind_factor<RelativePoint<Pose2, Point2>>(m);
  bind_factor<RelativePoint<Pose3, Point3>>(m);
  bind_factor<PositionStep<Point2, Point2>>(m);
  bind_factor<VonMisesBearingBody<Pose2, Point2>>(m);
  bind_factor<VonMisesBearingBody<Pose3, Point3>>(m);
  bind_factor<WhiteAcceleration<Motion2>>(m);
  bind_factor<WhiteJerk<Accel2>>(m);
  bind_factor<ConstantTurn<Motion2>>(m);
  bind_factor<CoordinatedTurn>(m);
  bind_factor<MissingDistance<Motion2, Point2>>(m);
  bind_factor<MissingDistance<Point2, Point2>>(m);
}

}  // namespace holdfast::python
