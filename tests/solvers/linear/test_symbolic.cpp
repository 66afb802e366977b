// The elimination tree against a brute-force elimination on small block graphs.
#include <gtest/gtest.h>

#include <algorithm>
#include <holdfast/solvers/linear/internal/symbolic.hpp>
#include <random>
#include <set>

namespace {

using holdfast::BlockGraph;
using holdfast::Symbolic;

BlockGraph random_graph(int n, double degree, unsigned seed) {
  std::mt19937_64 rng(seed);
  std::vector<std::set<int>> neighbours(n);
  for (int i = 1; i < n; ++i) {  // connected, like a trajectory
    neighbours[i].insert(i - 1);
    neighbours[i - 1].insert(i);
  }
  for (int e = 0; e < degree * n; ++e) {
    const int a = static_cast<int>(rng() % n), b = static_cast<int>(rng() % n);
    if (a == b) continue;
    neighbours[a].insert(b);
    neighbours[b].insert(a);
  }
  BlockGraph graph;
  for (int i = 0; i < n; ++i) {
    graph.dims.push_back(1 + static_cast<int>(rng() % 6));
    graph.neighbours.insert(graph.neighbours.end(), neighbours[i].begin(), neighbours[i].end());
    graph.begin.push_back(static_cast<int>(graph.neighbours.size()));
  }
  return graph;
}

// Rows of each column of L, by playing the elimination game.
std::vector<std::set<int>> fill(const BlockGraph& graph, const std::vector<int>& order) {
  std::vector<int> position(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) position[order[i]] = static_cast<int>(i);
  std::vector<std::set<int>> later(order.size());
  for (int i = 0; i < graph.size(); ++i)
    for (int e = graph.begin[i]; e < graph.begin[i + 1]; ++e)
      if (position[graph.neighbours[e]] > position[i]) later[position[i]].insert(position[graph.neighbours[e]]);
  for (std::size_t j = 0; j < later.size(); ++j) {
    if (later[j].empty()) continue;
    const int parent = *later[j].begin();
    for (int row : later[j])
      if (row != parent) later[parent].insert(row);
  }
  return later;
}

void expect_a_valid_tree(const BlockGraph& graph, const Symbolic& symbolic) {
  std::vector<int> sorted = symbolic.order;
  std::sort(sorted.begin(), sorted.end());
  for (int i = 0; i < graph.size(); ++i) ASSERT_EQ(sorted[i], i) << "every node once";
  const auto exact = fill(graph, symbolic.order);
  int column = 0;
  for (std::size_t s = 0; s < symbolic.supernodes.size(); ++s) {
    const Symbolic::Supernode& supernode = symbolic.supernodes[s];
    ASSERT_EQ(supernode.first, column);
    column = supernode.last;
    const std::set<int> rows(supernode.rows.begin(), supernode.rows.end());
    int k = 0, m = 0;
    for (int j = supernode.first; j < supernode.last; ++j) {
      k += graph.dims[symbolic.order[j]];
      for (int row : exact[j])
        EXPECT_TRUE(row < supernode.last || rows.count(row) == 1) << "row " << row << " of column " << j << " has no place";
    }
    for (int row : rows) m += graph.dims[symbolic.order[row]];
    EXPECT_EQ(supernode.k, k);
    EXPECT_EQ(supernode.n, k + m);
    if (supernode.rows.empty()) {
      EXPECT_EQ(supernode.parent, -1);
      continue;
    }
    ASSERT_GT(supernode.parent, static_cast<int>(s));
    const Symbolic::Supernode& parent = symbolic.supernodes[supernode.parent];
    for (int row : supernode.rows)
      EXPECT_TRUE(row < parent.last ? row >= parent.first : std::binary_search(parent.rows.begin(), parent.rows.end(), row));
  }
  EXPECT_EQ(column, graph.size());
}

TEST(Symbolic, EveryEntryOfTheFactorHasAPlaceInItsFront) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    const BlockGraph graph = random_graph(5 + 7 * static_cast<int>(seed), 0.3 * (seed % 4), seed);
    expect_a_valid_tree(graph, holdfast::analyze(graph));
    std::vector<int> natural(graph.size());
    for (int i = 0; i < graph.size(); ++i) natural[i] = i;
    expect_a_valid_tree(graph, holdfast::analyze(graph, natural));
    const std::vector<int> dissection = holdfast::nested_dissection_order(graph);
    if (!dissection.empty()) expect_a_valid_tree(graph, holdfast::analyze(graph, dissection));
  }
}

TEST(Symbolic, MinimumDegreeOfAChainMakesNoFill) {
  const BlockGraph chain = random_graph(200, 0, 5);
  for (const std::set<int>& rows : fill(chain, holdfast::minimum_degree_order(chain))) EXPECT_LE(rows.size(), 1u);
}

TEST(Symbolic, MinimumDegreeBeatsTheNaturalOrderOnAGrid) {
  BlockGraph grid;
  const int side = 20;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      grid.dims.push_back(3);
      if (y > 0) grid.neighbours.push_back((y - 1) * side + x);
      if (x > 0) grid.neighbours.push_back(y * side + x - 1);
      if (x + 1 < side) grid.neighbours.push_back(y * side + x + 1);
      if (y + 1 < side) grid.neighbours.push_back((y + 1) * side + x);
      grid.begin.push_back(static_cast<int>(grid.neighbours.size()));
    }
  std::vector<int> natural(grid.size());
  for (int i = 0; i < grid.size(); ++i) natural[i] = i;
  const auto size = [&](const std::vector<int>& order) {
    std::size_t blocks = 0;
    for (const std::set<int>& rows : fill(grid, order)) blocks += rows.size();
    return blocks;
  };
  EXPECT_LT(size(holdfast::minimum_degree_order(grid)), 0.7 * size(natural));
}

TEST(Symbolic, AGraphWithoutEdgesAndOneOfOneNodeAreTrees) {
  BlockGraph isolated;
  for (int i = 0; i < 4; ++i) {
    isolated.dims.push_back(2);
    isolated.begin.push_back(0);
  }
  expect_a_valid_tree(isolated, holdfast::analyze(isolated));
  BlockGraph one;
  one.dims.push_back(6);
  one.begin.push_back(0);
  expect_a_valid_tree(one, holdfast::analyze(one));
}

}  // namespace
