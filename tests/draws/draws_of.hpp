// From a list of factor types to draws; for the sources of this folder alone.
#pragma once

#include "tests/draws.hpp"
#include "tests/samples.hpp"

namespace holdfast::testing {

template <class F, std::size_t... I>
Draw draw_of(std::mt19937_64& rng, std::index_sequence<I...>) {
  static_assert(std::is_aggregate_v<F>, "a factor is a plain struct");
  using Vars = typename F::Variables;
  const F factor = Sample<F>::factor(rng);
  const std::array<Key, sizeof...(I)> keys{Key(static_cast<char>('C' - I), 7 + 3 * I)...};
  Draw draw;
  draw.label = factor_name<F>() + " on" + ((std::string(" ") + Vars::template type<I>::name()) + ...);
  draw.residual_dim = F::residual_dim;
  draw.linear = is_linear<F>;
  draw.convex = is_convex<F>;
  draw.keys.assign(keys.begin(), keys.end());
  draw.values = [keys](std::mt19937_64& random) {
    const auto x = Sample<F>::variables(random);
    Values values;
    (values.insert(keys[I], std::get<I>(x)), ...);
    return values;
  };
  draw.add = [factor, keys](Graph& graph, const Loss& loss, double weight) { graph.add(factor, keys, loss, weight); };
  draw.add_priors = [keys](Graph& graph, const Values& near, std::mt19937_64& random) {
    const auto add = [&](const auto& x, Key key) {
      using V = std::decay_t<decltype(x)>;
      graph.add(Prior<V>::from_sigmas(x.retract(random_vector<V::dim>(random, 0.1)), Vector<V::dim>::Constant(0.1)), {key});
    };
    (add(near.at<typename Vars::template type<I>>(keys[I]), keys[I]), ...);
  };
  draw.residual = [factor, keys](const Values& values, Eigen::MatrixXd* jacobian) -> Eigen::VectorXd {
    const auto residual = [&](Jacobians<F>* J) { return factor(values.at<typename Vars::template type<I>>(keys[I])..., J); };
    if (jacobian == nullptr) return residual(nullptr);
    Jacobians<F> J;
    J.all.setConstant(NAN);
    const Eigen::VectorXd r = residual(&J);
    *jacobian = J.all;
    return r;
  };
  draw.layouts = holdfast::detail::layouts_of<F>();
  draw.term = [factor](const Loss& loss, double weight) { return Term(factor, loss, weight); };
  return draw;
}

template <class List>
std::vector<Draw> draws_of(std::mt19937_64& rng) {
  std::vector<Draw> draws;
  for_each_type<List>([&](auto tag) {
    using F = typename decltype(tag)::type;
    draws.push_back(draw_of<F>(rng, std::make_index_sequence<F::Variables::size>{}));
  });
  return draws;
}

}  // namespace holdfast::testing
