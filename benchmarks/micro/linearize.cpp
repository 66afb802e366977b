// A whole linearisation, residuals and Jacobians of every factor added up to H and g, of real problems.
#include <benchmark/benchmark.h>

#include <filesystem>
#include <holdfast/benchmarks/suites/suites.hpp>
#include <holdfast/solvers/linear/internal/normal_equations.hpp>

namespace holdfast::bench {
namespace {

void linearize(::benchmark::State& state, const std::string& file) {
  const std::string path = (std::filesystem::path(data_directory()) / file).string();
  if (data_directory().empty() || !std::filesystem::is_regular_file(path)) {
    state.SkipWithError(("no data: there is no " + path + "; set HOLDFAST_DATA").c_str());
    return;
  }
  const Instance instance = load(path, {}).instance;
  const Resolved resolved(instance.graph, instance.start);
  std::vector<int> order;
  for (std::size_t i = 0; i < resolved.variables().size(); ++i)
    if (resolved.variables()[i].offset >= 0) order.push_back(static_cast<int>(i));
  NormalEquations equations(instance.graph, resolved, order);
  ThreadPool pool(static_cast<int>(state.range(0)));
  for (auto _ : state) ::benchmark::DoNotOptimize(equations.linearize(instance.graph, resolved, instance.start, Curvature::irls, &pool));
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * instance.graph.size()));
}

BENCHMARK_CAPTURE(linearize, plaza2, "range/plaza2.pyfg")
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->UseRealTime()
    ->Unit(::benchmark::kMicrosecond);
BENCHMARK_CAPTURE(linearize, sphere2500, "pose_graph/sphere2500.g2o")
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->UseRealTime()
    ->Unit(::benchmark::kMicrosecond);

}  // namespace
}  // namespace holdfast::bench
