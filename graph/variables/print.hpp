// Variables for people: std::cout << pose. "Point2(1, 2)", "Pose2(x, y, θ)", "Pose3(x, y, z, roll, pitch, yaw)" [m, rad], six digits.
// A type of your own prints as its name and its numbers, or as your own operator<< says.
#pragma once

#include <holdfast/graph/variables/kinematic.hpp>
#include <holdfast/graph/variables/pose2.hpp>
#include <holdfast/graph/variables/pose3.hpp>
#include <holdfast/graph/variables/turning2.hpp>
#include <iosfwd>

namespace holdfast {

namespace detail {
/// "Name(1, 2, 3)".
std::ostream& print_numbers(std::ostream& out, const char* name, const double* x, int n);
}  // namespace detail

template <int Axes, int Order>
std::ostream& operator<<(std::ostream& out, const Kinematic<double, Axes, Order>& x) {
  return detail::print_numbers(out, x.name(), x.value.data(), x.dim);
}
std::ostream& operator<<(std::ostream& out, const Scalar& x);
std::ostream& operator<<(std::ostream& out, const Turning2& x);
std::ostream& operator<<(std::ostream& out, const Pose2& x);
std::ostream& operator<<(std::ostream& out, const Pose3& x);

namespace detail {
template <class V, class = void>
struct HasPrint : std::false_type {};
template <class V>
struct HasPrint<V, std::void_t<decltype(std::declval<std::ostream&>() << std::declval<const V&>())>> : std::true_type {};

template <class V>
void print_variable(std::ostream& out, const V& x) {
  if constexpr (HasPrint<V>::value)
    out << x;
  else
    print_numbers(out, V::name(), reinterpret_cast<const double*>(&x), ambient_dim<V>);
}
}  // namespace detail

}  // namespace holdfast
