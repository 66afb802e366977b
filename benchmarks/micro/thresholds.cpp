// 10⁵ ranges: with a threshold each they are as quick to linearise as with one for all.
#include <benchmark/benchmark.h>

#include <holdfast/factors/range.hpp>
#include <holdfast/solvers/detail/clock.hpp>
#include <holdfast/solvers/linear/internal/normal_equations.hpp>
#include <random>

namespace holdfast {
namespace {

constexpr int kRanges = 100000, kPoints = 2000;

/// spread: thresholds are 2 to 2 + spread.
Graph ranges(double spread, Values& values) {
  std::mt19937_64 rng(1);
  std::uniform_real_distribution<double> any(0, 100);
  constexpr Agent A('A');
  values = Values();
  for (int i = 0; i < kPoints; ++i) values.insert(A(i), Point2(any(rng), any(rng)));
  Graph graph;
  for (int i = 0; i < kRanges; ++i) {
    const int a = static_cast<int>(rng() % kPoints), b = (a + 1 + static_cast<int>(rng() % 5)) % kPoints;
    graph.add(Range<Point2, Point2>{any(rng), 1}, {A(a), A(b)}, Huber{2 + spread * i / kRanges});
  }
  return graph;
}

double seconds_to_linearize(const Graph& graph, const Resolved& resolved, const Values& values, NormalEquations& equations) {
  const Stopwatch watch;
  ::benchmark::DoNotOptimize(equations.linearize(graph, resolved, values, Curvature::irls));
  return watch.seconds();
}

/// Paired, so that the machine's other work meets both; the quickest of each counts.
void thresholds(::benchmark::State& state) {
  Values values;
  const Graph one = ranges(0, values), many = ranges(1, values);
  const Resolved resolved(one, values), resolved_many(many, values);
  std::vector<int> order;
  for (int v = 0; v < static_cast<int>(resolved.variables().size()); ++v) order.push_back(v);
  NormalEquations equations(one, resolved, order), equations_many(many, resolved_many, order);
  double quickest_one = 1e9, quickest_many = 1e9;
  for (auto _ : state) {
    quickest_one = std::min(quickest_one, seconds_to_linearize(one, resolved, values, equations));
    quickest_many = std::min(quickest_many, seconds_to_linearize(many, resolved_many, values, equations_many));
  }
  state.counters["batches"] = static_cast<double>(many.batches().size());
  state.counters["many_to_one"] = quickest_many / quickest_one;
}
BENCHMARK(thresholds)->Unit(::benchmark::kMillisecond);

void add(::benchmark::State& state, double spread) {
  Values values;
  for (auto _ : state) ::benchmark::DoNotOptimize(ranges(spread, values).size());
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()) * kRanges);
}
BENCHMARK_CAPTURE(add, one_threshold, 0.0)->Unit(::benchmark::kMillisecond);
BENCHMARK_CAPTURE(add, a_threshold_each, 1.0)->Unit(::benchmark::kMillisecond);

}  // namespace
}  // namespace holdfast
