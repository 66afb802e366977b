// What a process holds of a graph that is spread over many: by hand, and the whole's cost.
#include <gmock/gmock.h>

#include "tests/solvers/distributed/parts.hpp"

namespace holdfast::testing {
namespace {

const Agent A('A');

Prior<Point2> at(double x) { return Prior<Point2>::from_sigmas(Point2(x, 0.0), Vector<2>(1, 1)); }
RangeBall<Point2, Point2> range(double distance) { return {distance, 1.0}; }

/// Point r in process r at (3r, 0); a ball of 1 m from each to the next, added by the owner of the latter or, where `by_first`, the former.
DistributedGraph row(const Communicator& all, bool by_first) {
  const auto me = static_cast<std::uint64_t>(all.rank());
  Graph graph;
  Values values;
  values.insert(A(me), Point2(3.0 * all.rank(), 0.0));
  graph.add(at(3.0 * all.rank()), {A(me)});
  if (by_first && all.rank() + 1 < all.size()) graph.add(range(1), {A(me), A(me + 1)});
  if (!by_first && all.rank() > 0) graph.add(range(1), {A(me - 1), A(me)});
  return DistributedGraph(all, std::move(graph), std::move(values));
}

TEST(DistributedGraph, EachFactorCountsOnceWhoeverAddsIt) {
  const Communicator all;
  for (bool by_first : {true, false}) {
    DistributedGraph graph = row(all, by_first);
    EXPECT_NEAR(graph.cost(), 0.5 * 4 * (all.size() - 1), 1e-12);  // ½ (3 − 1)² a link
    EXPECT_EQ(graph.total_factors(), 2 * all.size() - 1);
    EXPECT_EQ(graph.total_variables(), all.size());
  }
}

TEST(DistributedGraph, AProcessHoldsItsNeighboursBoundaryAndNoMore) {
  const Communicator all;
  const DistributedGraph graph = row(all, true);
  std::vector<int> beside;
  if (all.rank() > 0) beside.push_back(all.rank() - 1);
  if (all.rank() + 1 < all.size()) beside.push_back(all.rank() + 1);
  EXPECT_EQ(graph.neighbours(), beside);
  EXPECT_EQ(graph.ghosts(), beside.size());
  EXPECT_EQ(graph.boundary_numbers(), 2 * beside.size());
  EXPECT_EQ(graph.graph().size(), 1 + beside.size());
  EXPECT_TRUE(graph.is_own(A(static_cast<std::uint64_t>(all.rank()))));
  for (int other : beside) {
    EXPECT_FALSE(graph.is_own(A(static_cast<std::uint64_t>(other))));
    EXPECT_EQ(graph.values().at<Point2>(A(static_cast<std::uint64_t>(other))).position().x(), 3.0 * other);
  }
}

TEST(DistributedGraph, AFactorMayNameVariablesOfOthersOnly) {
  const Communicator all;
  Graph graph;
  Values values;
  values.insert(A(static_cast<std::uint64_t>(all.rank())), Point2(3.0 * all.rank(), 0.0));
  graph.add(at(3.0 * all.rank()), {A(static_cast<std::uint64_t>(all.rank()))});
  if (all.rank() == all.size() - 1 && all.size() > 1) graph.add(range(1), {A(0), A(1)});
  DistributedGraph spread(all, std::move(graph), std::move(values));
  EXPECT_NEAR(spread.cost(), all.size() > 1 ? 2.0 : 0.0, 1e-12);
}

TEST(DistributedGraph, AVariableThatItsOwnerFixesIsFixedForAll) {
  const Communicator all;
  Graph graph;
  Values values;
  const auto me = static_cast<std::uint64_t>(all.rank());
  values.insert(A(me), Point2(3.0 * all.rank(), 0.0));
  graph.add(at(0), {A(me)});
  if (all.rank() == 0) graph.fix(A(0));
  if (all.rank() > 0) graph.add(range(1), {A(0), A(me)});
  const DistributedGraph spread(all, std::move(graph), std::move(values));
  EXPECT_TRUE(spread.graph().is_fixed(A(0)));
  EXPECT_TRUE(spread.neighbours().empty()) << "a constant is sent once";
}

TEST(DistributedGraph, SaysInEveryProcessWhatOneDidWrong) {
  const Communicator all;
  const auto me = static_cast<std::uint64_t>(all.rank());
  const auto build = [&](Key mine, Key named) {
    Graph graph;
    Values values;
    values.insert(mine, Point2(0.0, 0.0));
    graph.add(range(1), {mine, named});
    DistributedGraph(all, std::move(graph), std::move(values));
  };
  try {
    build(A(me), A(1000));
    ADD_FAILURE() << "no process has A1000";
  } catch (const BadKey& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("A1000"));
  }
  if (all.size() == 1) return;
  EXPECT_THROW(build(A(0), A(1)), BadKey) << "all have A0";
  EXPECT_THROW(
      {
        Graph graph;
        Values values;
        if (all.rank() == 0) values.insert(A(0), Pose2());
        if (all.rank() == 1) {
          values.insert(A(1), Point2());
          graph.add(range(1), {A(0), A(1)});
        }
        DistributedGraph(all, std::move(graph), std::move(values));
      },
      BadType);
}

TEST(DistributedGraph, HasTheCostOfTheWhole) {
  const Communicator all;
  for (const Whole& whole : {range_network(300, 1), laps(200, 2)}) {
    DistributedGraph graph = part_of(whole, all);
    const double cost = whole.graph.cost(whole.values);
    EXPECT_NEAR(graph.cost(), cost, 1e-12 * cost);
    EXPECT_EQ(graph.total_factors(), static_cast<std::int64_t>(whole.graph.size()));
  }
}

}  // namespace
}  // namespace holdfast::testing
