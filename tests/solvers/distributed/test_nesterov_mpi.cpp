// "nesterov-mpi" in 1, 2 and 4 processes: nesterov's answer, and what it sends.
#include <gmock/gmock.h>

#include <holdfast/solvers/distributed/nesterov_mpi.hpp>

#include "tests/solvers/distributed/parts.hpp"

namespace holdfast::testing {
namespace {

TEST(NesterovMpi, ARangeNetworkHasTheCostOfIrls) {
  const Communicator all;
  const Whole whole = range_network(200, 3);
  Values by_irls = whole.values, by_one = whole.values;
  const Summary irls = solve("irls", whole.graph, by_irls, tight());
  Options options;
  options.cost_tolerance = 1e-13;
  const Summary one = NesterovMpi(options).solve(whole.graph, by_one);
  DistributedGraph graph = part_of(whole, all);
  const Summary many = NesterovMpi(options).solve(graph);
  EXPECT_EQ(one.termination, Termination::converged) << one;
  EXPECT_EQ(many.termination, Termination::converged) << many;
  EXPECT_NEAR(one.cost, irls.cost, 1e-8 * irls.cost);
  EXPECT_NEAR(many.cost, one.cost, 1e-9 * one.cost);
  EXPECT_NEAR(graph.cost(), many.cost, 1e-12 * many.cost);
  EXPECT_TRUE(many.is_convex);
}

TEST(NesterovMpi, APoseGraphEndsAtTheCostOfIrls) {
  const Communicator all;
  const Whole whole = laps(120, 4);
  Values by_irls = whole.values;
  const Summary irls = solve("irls", whole.graph, by_irls, tight());
  DistributedGraph graph = part_of(whole, all);
  Options options;
  options.cost_tolerance = 1e-12;
  const Summary many = NesterovMpi(options).solve(graph);
  EXPECT_NEAR(many.cost, irls.cost, 1e-7 * irls.cost) << many;
}

// Two exchanges an iteration where no step length is tried twice, and nothing else to neighbours.
TEST(NesterovMpi, SendsItsBoundaryToItsNeighboursAndNothingElse) {
  const Communicator all;
  DistributedGraph graph = part_of(range_network(200, 5), all);
  Options options;
  options.max_iterations = 40;
  graph.communicator().traffic() = {};
  const Summary summary = NesterovMpi(options).solve(graph);
  const Traffic& traffic = graph.communicator().traffic();
  const std::uint64_t neighbours = graph.neighbours().size();
  if (all.size() == 1) {
    EXPECT_EQ(traffic.messages, 0U);
    return;
  }
  ASSERT_GT(neighbours, 0U);
  EXPECT_EQ(traffic.messages % neighbours, 0U);
  const std::uint64_t exchanges = traffic.messages / neighbours;
  EXPECT_EQ(traffic.bytes, exchanges * graph.boundary_numbers() * sizeof(double));
  EXPECT_GE(exchanges, static_cast<std::uint64_t>(summary.iterations));
  EXPECT_LE(exchanges, static_cast<std::uint64_t>(4 * summary.iterations + 1));
}

TEST(NesterovMpi, AfterAFailureTheStartIsThere) {
  const Communicator all;
  Whole whole = range_network(100, 8);
  const Key last = whole.values.keys().back();
  whole.values.update(last, Point2(NAN, 0.0));
  DistributedGraph graph = part_of(whole, all);
  EXPECT_EQ(NesterovMpi().solve(graph).termination, Termination::failed);
}

}  // namespace
}  // namespace holdfast::testing
