// What every factor of the library owes to every back-end, over all variable types. The lists are spread over several test sources
// (test_samples_*.cpp) because they take long to compile.
#pragma once

#include <gtest/gtest.h>

#include "../samples.hpp"

namespace holdfast::testing {
inline constexpr int kDraws = 12;

template <class F>
double half_square(const F& factor, const typename F::Variables::Tuple& x) {
  return 0.5 * std::apply([&](const auto&... v) { return factor(v...).squaredNorm(); }, x);
}

/// x ⊕ δ, δ the tangent of all variables side by side.
template <class F, std::size_t... I>
typename F::Variables::Tuple retracted(const typename F::Variables::Tuple& x, const Vector<F::Variables::total_dim>& delta,
                                       std::index_sequence<I...>) {
  return {std::get<I>(x).retract(delta.template segment<F::Variables::dims[I]>(F::Variables::offsets[I]))...};
}
template <class F>
typename F::Variables::Tuple retracted(const typename F::Variables::Tuple& x, const Vector<F::Variables::total_dim>& delta) {
  return retracted<F>(x, delta, std::make_index_sequence<F::Variables::size>{});
}

template <class F>
std::pair<Residual<F>, Jacobians<F>> linearised(const F& factor, const typename F::Variables::Tuple& x) {
  Jacobians<F> J;
  const Residual<F> r = std::apply([&](const auto&... v) { return factor(v..., &J); }, x);
  return {r, J};
}

template <class F>
std::string label() {
  std::string text = factor_name<F>() + " on";
  std::apply([&](const auto&... v) { ((text += std::string(" ") + std::decay_t<decltype(v)>::name()), ...); },
             typename F::Variables::Tuple{});
  return text;
}

template <class F>
void expect_good_citizen() {
  SCOPED_TRACE(label<F>());
  static_assert(std::is_aggregate_v<F>, "a factor is a plain struct");
  std::mt19937_64 rng(7);
  for (int draw = 0; draw < kDraws; ++draw) {
    const F factor = Sample<F>::factor(rng);
    const auto x = Sample<F>::variables(rng);
    EXPECT_NO_THROW(factor.validate());
    EXPECT_LT(std::apply([&](const auto&... v) { return jacobian_error(factor, v...); }, x), 1e-8);

    const auto [r, J] = linearised(factor, x);
    const Vector<F::Variables::total_dim> delta = random_vector<F::Variables::total_dim>(rng, 2);
    const auto y = retracted<F>(x, delta);
    if constexpr (is_linear<F>) {
      EXPECT_LT((linearised(factor, y).first - r - J.all * delta).norm(), 1e-10 * (1 + r.norm()));
    }
    if constexpr (is_convex<F>) {  // above every tangent plane
      const double plane = 0.5 * r.squaredNorm() + r.dot(J.all * delta);
      EXPECT_GE(half_square(factor, y), plane - 1e-9 * (1 + r.squaredNorm()));
    }
  }
}

template <class List>
void expect_good_citizens() {
  for_each_type<List>([](auto tag) { expect_good_citizen<typename decltype(tag)::type>(); });
}

}  // namespace holdfast::testing
