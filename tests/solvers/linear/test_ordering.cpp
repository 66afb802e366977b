// Block graphs by hand, and elimination orders that name every node once and put what is expensive last.
#include <gtest/gtest.h>

#include <algorithm>
#include <holdfast/factors/between.hpp>
#include <holdfast/solvers/linear/internal/ordering.hpp>
#include <numeric>

namespace holdfast {
namespace {

constexpr Agent A('A');

Between<Point2> step() { return Between<Point2>::from_sigmas(Point2(1, 0), Vector<2>(1, 1)); }

std::vector<int> neighbours_of(const BlockGraph& graph, int node) {
  return {graph.neighbours.begin() + graph.begin[node], graph.neighbours.begin() + graph.begin[node + 1]};
}

TEST(BlockGraph, HasAnEdgeWhereFreeVariablesShareAFactor) {
  Graph graph;
  Values values;
  for (int i = 0; i < 4; ++i) values.insert(A(i), Point2());
  graph.add(step(), {A(2), A(0)});
  graph.add(step(), {A(0), A(2)});  // a second one changes nothing
  graph.add(step(), {A(0), A(1)});
  graph.add(step(), {A(1), A(3)});
  graph.fix(A(1));  // a fixed variable ties nothing
  const Resolved resolved(graph, values);
  std::vector<int> variable;
  const BlockGraph blocks = block_graph(graph, resolved, variable);
  ASSERT_EQ(blocks.size(), 3);
  EXPECT_EQ(blocks.dims, (std::vector<int>{2, 2, 2}));
  std::vector<Key> keys;
  for (int v : variable) keys.push_back(resolved.variables()[v].key);
  const auto node = [&](Key key) { return static_cast<int>(std::find(keys.begin(), keys.end(), key) - keys.begin()); };
  EXPECT_EQ(neighbours_of(blocks, node(A(0))), std::vector<int>{node(A(2))});
  EXPECT_EQ(neighbours_of(blocks, node(A(2))), std::vector<int>{node(A(0))});
  EXPECT_TRUE(neighbours_of(blocks, node(A(3))).empty());
}

/// Node 0 is heard by all others, which form a chain.
BlockGraph beacon_and_chain(int n) {
  BlockGraph graph;
  for (int i = 0; i < n; ++i) {
    graph.dims.push_back(3);
    if (i == 0)
      for (int k = 1; k < n; ++k) graph.neighbours.push_back(k);
    if (i > 0) graph.neighbours.push_back(0);
    if (i > 1) graph.neighbours.push_back(i - 1);
    if (i > 0 && i + 1 < n) graph.neighbours.push_back(i + 1);
    graph.begin.push_back(static_cast<int>(graph.neighbours.size()));
  }
  return graph;
}

void expect_every_node_once(std::vector<int> order, int n) {
  std::sort(order.begin(), order.end());
  std::vector<int> all(n);
  std::iota(all.begin(), all.end(), 0);
  EXPECT_EQ(order, all);
}

TEST(MinimumDegree, NamesEveryNodeOnceAndTheBeaconLast) {
  for (const int n : {2, 5, 17, 18, 400}) {
    const std::vector<int> order = minimum_degree_order(beacon_and_chain(n));
    expect_every_node_once(order, n);
    if (n > 5) {
      EXPECT_GE(std::find(order.begin(), order.end(), 0) - order.begin(), n - 3) << n;
    }
  }
  EXPECT_EQ(minimum_degree_order(beacon_and_chain(400)).back(), 0);
}

TEST(MinimumDegree, OfNothingIsNothing) { EXPECT_TRUE(minimum_degree_order(BlockGraph{}).empty()); }

TEST(NestedDissection, NamesEveryNodeOnce) {
  const std::vector<int> order = nested_dissection_order(beacon_and_chain(50));
  if (order.empty()) GTEST_SKIP() << "built without METIS";
  expect_every_node_once(order, 50);
}

TEST(NestedDissection, IsEmptyWithoutNeighbours) {
  BlockGraph alone;
  alone.dims = {2, 2};
  alone.begin = {0, 0, 0};
  EXPECT_TRUE(nested_dissection_order(alone).empty());
}

}  // namespace
}  // namespace holdfast
