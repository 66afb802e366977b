// AutoDiff<F> gives a struct with a templated residual its Jacobians (forward mode, exact to rounding, in the tangent):
//
//   struct MyRange {
//     double distance, sigma;                                                           // [m]
//     using Variables = variables<Pose2, Point2>;
//     static constexpr int residual_dim = 1;
//     template <class T>
//     VectorT<T, 1> residual(const Pose2T<T>& a, const Point2T<T>& b) const {
//       using std::sqrt;
//       return VectorT<T, 1>((sqrt((a.position() - b.position()).squaredNorm()) - distance) / sigma);
//     }
//   };
//   graph.add(AutoDiff<MyRange>{{12.3, 0.5}}, {A(0), L(0)});
#pragma once

#include <holdfast/graph/detail/dual.hpp>
#include <holdfast/graph/factor.hpp>

namespace holdfast {

template <class F, class Variables = typename F::Variables>
struct AutoDiff;

template <class F, class... V>
struct AutoDiff<F, variables<V...>> : F {
  using Variables = variables<V...>;

  Vector<F::residual_dim> operator()(const V&... x, Jacobians<AutoDiff>* J = nullptr) const {
    if (J != nullptr) differentiate(std::index_sequence_for<V...>{}, *J, x...);
    return F::template residual<double>(x...);  // the same bits with and without Jacobians
  }
  static std::string name() { return factor_name<F>(); }

 private:
  using D = Dual<Variables::total_dim>;

  template <std::size_t... I>
  void differentiate(std::index_sequence<I...>, Jacobians<AutoDiff>& J, const V&... x) const {
    const VectorT<D, F::residual_dim> r = F::template residual<D>(seeded<I>(x)...);
    for (int row = 0; row < F::residual_dim; ++row) J.all.row(row) = r[row].v.transpose();
  }

  /// The variable moved by an infinitesimal along its own tangent columns.
  template <std::size_t I, class X>
  static auto seeded(const X& x) {
    VectorT<D, X::dim> delta;
    for (int k = 0; k < X::dim; ++k) delta[k] = D(0, Vector<Variables::total_dim>::Unit(Variables::offsets[I] + k));
    return x.template cast<D>().retract(delta);
  }
};

}  // namespace holdfast
