// Which variables are vector spaces: retract adds the tangent, so differences of variables are linear.
#pragma once

#include <holdfast/graph/variables.hpp>
#include <type_traits>

namespace holdfast {

namespace detail {
template <class V>
struct IsVectorSpace : std::false_type {};
template <class T, int Axes, int Order>
struct IsVectorSpace<Kinematic<T, Axes, Order>> : std::true_type {};
template <class T>
struct IsVectorSpace<ScalarT<T>> : std::true_type {};
}  // namespace detail

template <class V>
inline constexpr bool is_vector_space = detail::IsVectorSpace<V>::value;

}  // namespace holdfast
