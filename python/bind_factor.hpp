// Every factor by one template over its fields (graph/fields.hpp): a new factor is one line in the source of its topic.
#pragma once

#include <holdfast/solvers/window/schedule.hpp>

#include "bind.hpp"

namespace holdfast::python {

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

/// The bits of its fields: what makes two factors equal.
template <class F>
std::string bytes_of(const F& factor) {
  std::string bytes(detail::field_bytes<F>(), '\0');
  char* out = bytes.data();
  detail::put_field(factor, out);
  return bytes;
}

/// For pickle: its fields with their types, and their bits.
template <class F>
nb::tuple state_of(const F& factor) {
  const std::string bytes = bytes_of(factor);
  return nb::make_tuple(detail::types_of_fields<F>(), nb::bytes(bytes.data(), bytes.size()));
}

template <class F>
F from_state(const nb::tuple& state) {
  const auto fields = nb::cast<std::string>(state[0]);
  const auto bytes = nb::cast<nb::bytes>(state[1]);
  if (fields != detail::types_of_fields<F>() || bytes.size() != detail::field_bytes<F>())
    fail<BadFile>("the pickled ", F::name(), " has the fields {", fields, "}, here it has {", detail::types_of_fields<F>(), "}");
  F factor{};
  const char* in = bytes.c_str();
  detail::get_field(factor, in);
  return factor;
}

template <class F, std::size_t... I>
std::string name_of(std::index_sequence<I...>) {
  return F::name() + (std::string() + ... + (std::string("_") + F::Variables::template type<I>::name()));
}

/// Range_Pose2_Point2, which holdfast/__init__.py gives as Range[Pose2, Point2].
template <class F>
nb::class_<F> bind_factor(nb::module_& m) {
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
        require_unused(&graph, "Graph");
        return add(graph, factor, keys_of<F>(keys), loss, weight);
      },
      "graph"_a, "keys"_a, "loss"_a.none(), "weight"_a.none());
  c.attr("fields") = detail::types_of_fields<F>();
  c.def("__getstate__", [](const F& factor) { return state_of(factor); });
  c.def("__setstate__", [](F& factor, const nb::tuple& state) { new (&factor) F(from_state<F>(state)); });
  c.def("__eq__", [](const F& a, const F& b) { return bytes_of(a) == bytes_of(b); });
  c.def("__eq__", [](const F&, nb::handle) { return nb::borrow(Py_NotImplemented); });
  return c;
}

}  // namespace holdfast::python
