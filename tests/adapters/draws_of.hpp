// From a list of factor types to draws; for draws_*.cpp alone.
#pragma once

#include "../samples.hpp"
#include "draws.hpp"

namespace holdfast::testing {

template <class F, std::size_t... I>
HostDraw host_draw(std::mt19937_64& rng, std::index_sequence<I...>) {
  using Vars = typename F::Variables;
  const F factor = Sample<F>::factor(rng);
  const std::array<Key, sizeof...(I)> keys{Key(static_cast<char>('C' - I), 7 + 3 * I)...};
  HostDraw draw;
  draw.label = factor_name<F>() + " on" + ((std::string(" ") + Vars::template type<I>::name()) + ...);
  draw.residual_dim = F::residual_dim;
  draw.keys.assign(keys.begin(), keys.end());
  draw.layouts = holdfast::detail::layouts_of<F>();
  draw.values = [keys](std::mt19937_64& random) {
    const auto x = Sample<F>::variables(random);
    Values values;
    (values.insert(keys[I], std::get<I>(x)), ...);
    return values;
  };
  draw.term = [factor](const Loss& loss, double weight) { return Term(factor, loss, weight); };
  draw.add = [factor, keys](Graph& graph, const Loss& loss, double weight) { graph.add(factor, keys, loss, weight); };
  return draw;
}

template <class List>
std::vector<HostDraw> draws_of(std::mt19937_64& rng) {
  std::vector<HostDraw> draws;
  for_each_type<List>([&](auto tag) {
    using F = typename decltype(tag)::type;
    draws.push_back(host_draw<F>(rng, std::make_index_sequence<F::Variables::size>{}));
  });
  return draws;
}

}  // namespace holdfast::testing
