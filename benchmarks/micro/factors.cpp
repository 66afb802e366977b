// One evaluation with Jacobian of each factor, on each combination of variables that is listed here.
#include <benchmark/benchmark.h>

#include <holdfast/factors/bearing_ray.hpp>
#include <holdfast/factors/between.hpp>
#include <holdfast/factors/constant_turn.hpp>
#include <holdfast/factors/coordinated_turn.hpp>
#include <holdfast/factors/huber_measurement.hpp>
#include <holdfast/factors/missing_distance.hpp>
#include <holdfast/factors/position_step.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/factors/range_ball.hpp>
#include <holdfast/factors/range_bearing.hpp>
#include <holdfast/factors/range_bearing_ball.hpp>
#include <holdfast/factors/relative_point.hpp>
#include <holdfast/factors/von_mises_bearing.hpp>
#include <holdfast/factors/white_acceleration.hpp>
#include <holdfast/factors/white_jerk.hpp>
#include <string>

#include "tests/conforms.hpp"

namespace holdfast {
namespace {

using namespace testing;  // the lists of types

using Timed =
    Flat<HuberMeasurement<Point2>, HuberMeasurement<Motion2>, HuberMeasurement<Motion3>, HuberMeasurement<Motion2, 4>,
         HuberMeasurementEdge<Motion2, Motion2>, HuberMeasurementEdge<Point3, Motion3>, WhiteAcceleration<Motion2>,
         WhiteAcceleration<Motion3>, WhiteJerk<Accel2>, WhiteJerk<Accel3>, ConstantTurn<Motion2>, CoordinatedTurn, MissingDistancePrior,
         OnPairs<Range>, OnSomePairs<RangeBall>, OnSomePairs<RangeBearingBall>, OnSomePairs<MissingDistance>,
         OnSomePairs<MissingDistanceBall>, OnSomePairs<VonMisesBearing>, OnPoses<VonMisesBearingBody>, OnPoses<RelativePoint>,
         OnSomePairs<PositionStep>, OnSomePairs<RangeBearing>, OnSomePairs<BearingRay>, OnAll<Prior>, OnAll<Between>>;

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

template <class... F>
bool register_all(std::tuple<F...>*) {
  const auto name = [](auto* variables, const std::string& factor, int rows) {
    return factor + "<" + names(variables) + ">/r" + std::to_string(rows);
  };
  (::benchmark::RegisterBenchmark(name(static_cast<typename F::Variables*>(nullptr), factor_name<F>(), F::residual_dim).c_str(),
                                  evaluate<F>),
   ...);
  return true;
}
const bool registered = register_all(static_cast<Timed*>(nullptr));

}  // namespace
}  // namespace holdfast
