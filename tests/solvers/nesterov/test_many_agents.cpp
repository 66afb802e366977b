// As many agents as a swarm has, each with its own key: memory and time must be linear in their number.
#include <gtest/gtest.h>

#include <holdfast/factors/position_step.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/graph/check.hpp>
#include <holdfast/solvers/nesterov/nesterov.hpp>
#include <random>

namespace holdfast {
namespace {

constexpr std::uint64_t kSteps = 3;

/// Agents that rest on a line, 10 m apart: each position measured, as are the ranges to the next agent, all without error.
struct Swarm {
  Graph graph;
  Values start, truth;

  explicit Swarm(std::uint64_t agents) {
    std::mt19937_64 rng(5);
    const auto error = [&] { return static_cast<double>(rng() >> 11) * 0x1p-53 - 0.5; };  // [m]
    for (std::uint64_t i = 0; i < agents; ++i) {
      const Agent agent('r', i);
      const Point2 p(10 * static_cast<double>(i), 0);
      for (std::uint64_t step = 0; step < kSteps; ++step) {
        truth.insert(agent(step), p);
        start.insert(agent(step), Point2(p.value + Vector<2>(error(), error())));
        graph.add(Prior<Point2>::from_sigmas(p, Vector<2>::Constant(0.5)), {agent(step)});
        if (step > 0) graph.add(PositionStep<Point2, Point2>{0.1}, {agent(step - 1), agent(step)});
        if (i > 0) graph.add(Range<Point2, Point2>{10, 0.2}, {Agent('r', i - 1)(step), agent(step)});
      }
    }
  }
};

TEST(ManyAgents, AHundredThousandWithThreeStepsEachAreSolved) {
  const Swarm swarm(100'000);
  Values values = swarm.start;
  Options options;
  options.cost_tolerance = 1e-10;
  const Summary summary = Nesterov(options).solve(swarm.graph, values);
  EXPECT_EQ(summary.termination, Termination::converged) << summary.str();
  EXPECT_LT(summary.cost, 1e-6 * summary.cost_first) << summary.str();
  double furthest = 0;  // [m]
  for (int i = 0; i < static_cast<int>(values.size()); ++i)
    furthest = std::max(furthest, (values.data<Point2>()[i].value - swarm.truth.data<Point2>()[i].value).norm());
  EXPECT_LT(furthest, 0.01);
}

// What is found is said of a few agents by name, and of the others by number.
TEST(ManyAgents, ChecksNameAFew) {
  Graph graph;
  Values values;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    values.insert(Agent('r', i)(0), Point2(10 * static_cast<double>(i), 0));
    if (i > 0) graph.add(Range<Point2, Point2>{10, 0.2}, {Agent('r', i - 1)(0), Agent('r', i)(0)});
  }
  bool found = false;
  for (const Finding& finding : check(graph, values)) {
    EXPECT_LT(finding.text.size(), 1000u);
    found = found || finding.text.find("1 of agent r7 from r7:0, and those of 992 more agents") != std::string::npos;
  }
  EXPECT_TRUE(found);
}

}  // namespace
}  // namespace holdfast
