// The variable concept: what a type must have to be estimated.
//
//   struct V {
//     static constexpr int dim;                              // tangent dimension
//     static const char* name();                             // "Pose2"
//     template <class U> using rebind = …;                   // the same type over another scalar (AutoDiff)
//     template <class U> rebind<U> cast() const;
//     V retract(const VectorT<T, dim>& delta) const;         // x ⊕ δ
//     VectorT<T, dim> local(const V& other) const;           // other ⊖ x: x.retract(x.local(y)) == y
//     bool is_finite() const;
//     static constexpr bool is_vector_space = true;          // where retract adds
//     Matrix<dim, dim> local_jacobian(const V& other) const; // d local(other ⊕ δ) / dδ at δ = 0; without it: by dual numbers
//     // where it has a position in the world:
//     static constexpr int space_dim;                        // 2 or 3
//     VectorT<T, space_dim> position() const;                // p_world [m]
//     static Matrix<space_dim, dim> position_jacobian();     // d position / d δ: a constant for every type of ours
//     VectorT<T, dim> rigid_motion(v, w) const;              // tangent velocity when the world moves by v + w × p
//   };
//
// A variable is a plain struct of doubles and nothing else (standard layout): its memory is its ambient coordinates.
//
// Convention (the project's one place for it): the tangent is ordered translation, rotation. Poses are R^n × SO(n):
// the translation moves in the WORLD frame, p ⊕ δp = p + δp, the rotation is perturbed on the right, R ⊕ δθ = R Exp(δθ).
// So the position of every variable is linear in its tangent, with a constant Jacobian.
#pragma once

#include <holdfast/graph/math.hpp>
#include <type_traits>

namespace holdfast {

namespace detail {
template <class V, class = void>
struct SpaceDim : std::integral_constant<int, 0> {};
template <class V>
struct SpaceDim<V, std::void_t<decltype(V::space_dim)>> : std::integral_constant<int, V::space_dim> {};
}  // namespace detail

namespace detail {
template <class V, class = void>
struct IsVectorSpace : std::false_type {};
template <class V>
struct IsVectorSpace<V, std::enable_if_t<V::is_vector_space>> : std::true_type {};
}  // namespace detail

/// Differences of such variables are linear in them.
template <class V>
inline constexpr bool is_vector_space = detail::IsVectorSpace<V>::value;

/// 2 or 3 for a variable with a position, 0 for one without.
template <class V>
inline constexpr int space_dim = detail::SpaceDim<V>::value;

/// Number of doubles a variable is made of.
template <class V>
inline constexpr int ambient_dim = static_cast<int>(sizeof(V) / sizeof(double));

/// w × p: in the plane w is one rate [rad/s], in space a vector.
template <class T>
VectorT<T, 2> cross(const VectorT<T, 1>& w, const VectorT<T, 2>& p) {
  return {-w[0] * p[1], w[0] * p[0]};
}
template <class T>
VectorT<T, 3> cross(const VectorT<T, 3>& w, const VectorT<T, 3>& p) {
  return {w[1] * p[2] - w[2] * p[1], w[2] * p[0] - w[0] * p[2], w[0] * p[1] - w[1] * p[0]};
}

/// Degrees of freedom of a rotation in 2 or 3 dimensions.
template <int Space>
inline constexpr int rotation_dim = Space == 2 ? 1 : 3;

}  // namespace holdfast
