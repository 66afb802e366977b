// The factor concept: a factor is a plain struct. A complete one, and all that is needed to run it in every back-end:
//
//   struct SpeedLimit {                                     // (‖velocity‖ − limit) / sigma where too fast, else 0
//     double limit;                                         // [m/s]
//     double sigma;                                         // [m/s]
//     using Variables = variables<Motion2>;
//     static constexpr int residual_dim = 1;
//     Vector<1> operator()(const Motion2& x, Jacobians<SpeedLimit>* J = nullptr) const;   // J wrt the tangent
//   };
//   graph.add(SpeedLimit{3.0, 0.1}, {A(4)}, Huber{2.0});
//
// The residual is whitened (in sigmas). When J is null only the residual is wanted; otherwise every entry of J->all must be
// written. Optional members, each unknown to those who do not ask:
//   static const char* name();                              // for messages; without it the C++ type's name
//   static constexpr auto fields();                         // its members by name, for files (graph/fields.hpp); without it: not saved
//   void validate() const;                                  // throws BadNumber; called by Graph::add
//   static Loss default_loss();                             // when the user gives none (otherwise Squared)
//   double default_weight() const;                          // when the user gives none (otherwise 1)
//   static constexpr bool is_linear = true;                 // constant Jacobian: r(x ⊕ δ) = r(x) + J δ exactly
//   static constexpr bool is_convex = true;                 // ½‖r‖² is a convex function of the variables
//   auto relaxed() const;                                   // its convex counterpart (convex_start)
//   const Pose2& relative_pose() const;                     // the second variable in the frame of the first, as measured; its noise in a
//                                                           // member sqrt_information (chordal_start)
//   auto merged(int m) const;                               // one factor for m empty steps (Window)
//   Matrix<N, N> hessian(const V&... x) const;              // of ½‖r‖², by the tangents side by side (N = Variables::total_dim), exact
//                                                           // where JᵀJ is a poor model of it. Of a convex factor it is positive
//                                                           // semidefinite (at a kink one of many); others may be indefinite, and say so.
//                                                           // Asked for by Curvature::exact
//   Residual raw(const Residual& r) const;                  // the residual r in the measurement's own units (outlier_report)
#pragma once

#include <array>
#include <holdfast/graph/detail/demangled.hpp>
#include <holdfast/graph/fields.hpp>
#include <holdfast/graph/manifold.hpp>
#include <tuple>
#include <utility>

namespace holdfast {

/// The variable types of a factor, in the order of its keys.
template <class... V>
struct variables {
  static constexpr int size = sizeof...(V);
  static constexpr std::array<int, size> dims{V::dim...};
  static constexpr int total_dim = (0 + ... + V::dim);
  using Tuple = std::tuple<V...>;
  template <int I>
  using type = std::tuple_element_t<I, Tuple>;

  /// First tangent column of variable I.
  static constexpr std::array<int, size> offsets = [] {
    std::array<int, size> first{};
    for (int i = 1; i < size; ++i) first[i] = first[i - 1] + dims[i - 1];
    return first;
  }();
};

/// d residual / d tangent of all variables side by side; wrt<I>() is the block of variable I.
template <class F>
struct Jacobians {
  using Variables = typename F::Variables;
  Matrix<F::residual_dim, Variables::total_dim> all;

  template <int I>
  auto wrt() {
    return all.template middleCols<Variables::dims[I]>(Variables::offsets[I]);
  }
  template <int I>
  auto wrt() const {
    return all.template middleCols<Variables::dims[I]>(Variables::offsets[I]);
  }
};

template <class F>
using Residual = Vector<F::residual_dim>;

namespace detail {
template <class F, class = void>
struct IsLinear : std::false_type {};
template <class F>
struct IsLinear<F, std::enable_if_t<F::is_linear>> : std::true_type {};
template <class F, class = void>
struct IsConvex : std::false_type {};
template <class F>
struct IsConvex<F, std::enable_if_t<F::is_convex>> : std::true_type {};
template <class F, class = void>
struct HasName : std::false_type {};
template <class F>
struct HasName<F, std::void_t<decltype(F::name())>> : std::true_type {};
template <class F, class = void>
struct HasValidate : std::false_type {};
template <class F>
struct HasValidate<F, std::void_t<decltype(std::declval<const F&>().validate())>> : std::true_type {};
template <class F, class = void>
struct HasDefaultLoss : std::false_type {};
template <class F>
struct HasDefaultLoss<F, std::void_t<decltype(F::default_loss())>> : std::true_type {};
template <class F, class = void>
struct HasDefaultWeight : std::false_type {};
template <class F>
struct HasDefaultWeight<F, std::void_t<decltype(std::declval<const F&>().default_weight())>> : std::true_type {};
template <class F, class = void>
struct HasRelaxed : std::false_type {};
template <class F>
struct HasRelaxed<F, std::void_t<decltype(std::declval<const F&>().relaxed())>> : std::true_type {};
template <class F, class Variables = typename F::Variables, class = void>
struct HasHessian : std::false_type {};
template <class F, class... V>
struct HasHessian<F, variables<V...>, std::void_t<decltype(std::declval<const F&>().hessian(std::declval<const V&>()...))>>
    : std::true_type {};
template <class F, class = void>
struct HasRelativePose : std::false_type {};
template <class F>
struct HasRelativePose<F, std::void_t<decltype(std::declval<const F&>().relative_pose())>> : std::true_type {};
}  // namespace detail

template <class F>
inline constexpr bool is_linear = detail::IsLinear<F>::value;
/// A linear factor is convex, too.
template <class F>
inline constexpr bool is_convex = detail::IsConvex<F>::value || detail::IsLinear<F>::value;

/// It says hessian().
template <class F>
inline constexpr bool has_hessian = detail::HasHessian<F>::value;

/// "RangeBall": what messages call a factor.
template <class F>
std::string factor_name() {
  if constexpr (detail::HasName<F>::value)
    return F::name();
  else
    return detail::demangled(typeid(F));
}

}  // namespace holdfast
