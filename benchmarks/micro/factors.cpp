// One evaluation with Jacobian of every factor on every combination of variables that the library ships.
#include <benchmark/benchmark.h>

#include <string>

#include "tests/samples.hpp"

namespace holdfast {
namespace {

template <class... V>
std::string names(variables<V...>*) {
  std::string all;
  ((all += (all.empty() ? "" : ", ") + std::string(V::name())), ...);
  return all;
}

template <class F>
void evaluate(::benchmark::State& state) {
  constexpr int kSamples = 64;  // fit into the first-level cache, and defeat the branch predictor a little
  std::mt19937_64 rng(1);
  std::vector<F> factors;
  std::vector<typename F::Variables::Tuple> x;
  for (int i = 0; i < kSamples; ++i) {
    factors.push_back(testing::Sample<F>::factor(rng));
    x.push_back(testing::Sample<F>::variables(rng));
  }
  Jacobians<F> J;
  for (auto _ : state) {
    for (int i = 0; i < kSamples; ++i) {
      const auto r = std::apply([&](const auto&... v) { return factors[i](v..., &J); }, x[i]);
      ::benchmark::DoNotOptimize(r.data());
      ::benchmark::DoNotOptimize(J.all.data());
      ::benchmark::ClobberMemory();
    }
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()) * kSamples);
}

const bool registered = [] {
  testing::for_each_type<testing::AllFactors>([](auto tag) {
    using F = typename decltype(tag)::type;
    const std::string name =
        factor_name<F>() + "<" + names(static_cast<typename F::Variables*>(nullptr)) + ">/r" + std::to_string(F::residual_dim);
    ::benchmark::RegisterBenchmark(name.c_str(), evaluate<F>);
  });
  return true;
}();

}  // namespace
}  // namespace holdfast
