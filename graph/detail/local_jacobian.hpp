// d from.local(to ⊕ δ) / dδ at δ = 0: the identity of a vector space, the variable's own, or by dual numbers.
#pragma once

#include <holdfast/graph/detail/dual.hpp>
#include <holdfast/graph/manifold.hpp>

namespace holdfast {

namespace detail {
template <class V, class = void>
struct HasLocalJacobian : std::false_type {};
template <class V>
struct HasLocalJacobian<V, std::void_t<decltype(std::declval<const V&>().local_jacobian(std::declval<const V&>()))>> : std::true_type {};
}  // namespace detail

template <class V>
Matrix<V::dim, V::dim> local_jacobian(const V& from, const V& to) {
  if constexpr (is_vector_space<V>) {
    return Matrix<V::dim, V::dim>::Identity();
  } else if constexpr (detail::HasLocalJacobian<V>::value) {
    return from.local_jacobian(to);
  } else {
    using D = Dual<V::dim>;
    VectorT<D, V::dim> delta;
    for (int k = 0; k < V::dim; ++k) delta[k] = D(0, Vector<V::dim>::Unit(k));
    const VectorT<D, V::dim> local = from.template cast<D>().local(to.template cast<D>().retract(delta));
    Matrix<V::dim, V::dim> J;
    for (int k = 0; k < V::dim; ++k) J.row(k) = local[k].v.transpose();
    return J;
  }
}

}  // namespace holdfast
