#include <holdfast/benchmarks/scenarios/scenario.hpp>
#include <holdfast/benchmarks/suites/suites.hpp>

namespace holdfast::bench {

std::vector<Case> scenario_cases(unsigned seed) {
  const auto unicycle_of = [seed](int states) {
    return [seed, states] {
      UnicycleOptions options;
      options.states = states;
      return unicycle(options, seed);
    };
  };
  const auto ring_of = [seed](const char* loss) {
    return Case{"ring-300", loss, "odometry", [seed, loss] { return ring(300, Loss::parse(loss), seed); }};
  };
  return {
      {"unicycle-15", "huber:2:component", "measurements", unicycle_of(15)},
      {"unicycle-400", "huber:2:component", "measurements", unicycle_of(400)},
      {"swarm-100", "squared", "anywhere", [seed] { return swarm(100, seed); }},
      {"swarm-1000", "squared", "anywhere", [seed] { return swarm(1000, seed); }},
      {"formation-50%-lost", "squared", "centre", [seed] { return formation(0.5, seed); }},
      ring_of("squared"),
      ring_of("cauchy:2"),
      ring_of("geman_mcclure:2"),
  };
}

}  // namespace holdfast::bench
