// Built-in scenarios as the measurements of a file, with their truth; noise, outliers and losses to choose.
#pragma once

#include <holdfast/benchmarks/scenarios/scenario.hpp>

namespace holdfast::bench {

struct SimulationOptions {
  std::string scenario = "fleet";
  int agents = 0;       ///< of a fleet, nodes of a swarm or a network; 0: the scenario's own number
  int steps = 0;        ///< of every agent that moves; 0: the scenario's own number
  double noise = 1;     ///< times the scenario's own, in the measurements and in what they say of their noise
  double outliers = 0;  ///< share of false ranges and closures
  double lost = 0;      ///< share of ranges and closures that are not there
  unsigned seed = 1;
};

/// "fleet: robots, odometry, …"
struct SimulatedScenario {
  const char* name;
  const char* what;
  int agents, steps;  ///< its own numbers; 0: it has none to choose
};
const std::vector<SimulatedScenario>& simulated_scenarios();

struct Simulation {
  Dataset dataset;  ///< in g2o's convention; its vertices are the start
  Values truth;
  std::size_t false_measurements = 0;
  std::size_t lost_measurements = 0;
};

/// The same for the same options. A false range is 5 to 50 m too long, a false closure claims that two poses are one; odometry and priors
/// are never false and never lost. BadOption where a number makes no sense, with what is allowed.
Simulation simulate(const SimulationOptions& options);

}  // namespace holdfast::bench
