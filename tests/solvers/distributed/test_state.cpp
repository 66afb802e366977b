// A solve's state in files: read by as many processes as there then are; broken ones are named.
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <holdfast/solvers/distributed/petsc.hpp>
#include <holdfast/solvers/distributed/state.hpp>

#include "tests/solvers/distributed/parts.hpp"

namespace holdfast::testing {
namespace {

/// An empty directory, the same in every process.
std::string directory(const Communicator& all, const std::string& name) {
  const std::string path = "state_" + name + "_on_" + std::to_string(all.size());
  if (all.rank() == 0) std::filesystem::remove_all(path);
  all.sum(0.0);
  return path;
}

TEST(State, IsThatOfTheLastIteration) {
  const Communicator all;
  const Whole whole = range_network(200, 11);
  const std::string path = directory(all, "resumed");
  DistributedGraph graph = part_of(whole, all);
  EXPECT_EQ(load_state(graph, path), 0) << "nothing is there yet";
  Options options = tight();
  options.progress = [&](const Iteration& iteration) {
    save_state(graph, path, iteration.number);
    return iteration.number < 3;  // "killed"
  };
  const Summary killed = Petsc(options).solve(graph);
  all.sum(0.0);
  DistributedGraph resumed = part_of(whole, all);
  EXPECT_EQ(load_state(resumed, path), resumed.total_variables());
  EXPECT_NEAR(resumed.cost(), killed.cost, 1e-12 * killed.cost);
  EXPECT_LT(resumed.cost(), killed.cost_first);
}

// One process saves all of it, then many read it.
TEST(State, IsReadByAnotherNumberOfProcesses) {
  const Communicator all;
  const Whole whole = range_network(150, 12);
  const std::string path = directory(all, "spread");
  Whole moved = whole;
  const Summary one = Petsc(tight()).solve(moved.graph, moved.values);
  if (all.rank() == 0) {
    DistributedGraph alone(Communicator::alone(), moved.graph, moved.values);
    load_state(alone, path);
    save_state(alone, path, 3);
  }
  all.sum(0.0);
  DistributedGraph graph = part_of(whole, all);
  EXPECT_EQ(load_state(graph, path), 150);
  EXPECT_NEAR(graph.cost(), one.cost, 1e-12 * one.cost);
}

TEST(State, ALaterJobCountsMoreThanALaterIteration) {
  const Communicator all;
  const Whole whole = range_network(60, 13);
  const std::string path = directory(all, "later");
  const Key key = whole.values.keys()[5];
  for (int job = 0; job < 2; ++job) {
    DistributedGraph graph = part_of(whole, all);
    load_state(graph, path);
    if (graph.is_own(key)) graph.values().update(key, Point2(10.0 + job, 0.0));
    all.sum(0.0);
    save_state(graph, path, job == 0 ? 100 : 1);
    all.sum(0.0);
  }
  DistributedGraph graph = part_of(whole, all);
  load_state(graph, path);
  if (graph.values().contains(key)) {
    EXPECT_EQ(graph.values().at<Point2>(key).position().x(), 11.0);
  }
}

TEST(State, AFileThatIsNoneIsNamedInEveryProcess) {
  const Communicator all;
  const std::string path = directory(all, "broken");
  DistributedGraph graph = part_of(range_network(60, 14), all);
  load_state(graph, path);
  if (all.rank() == 0) std::ofstream(path + "/part-7.state") << "not a state";
  all.sum(0.0);
  try {
    load_state(graph, path);
    ADD_FAILURE();
  } catch (const BadFile& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("part-7.state"));
  }
}

}  // namespace
}  // namespace holdfast::testing
