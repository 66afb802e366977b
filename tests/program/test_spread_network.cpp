// The network that each process makes a part of: as many nodes as asked for, and the same for any number of processes.
#include <gtest/gtest.h>

#include <holdfast/program/spread_network.hpp>

namespace holdfast::program {
namespace {

TEST(SpreadNetwork, IsTheSameForAnyNumberOfProcesses) {
  for (std::int64_t nodes : {100, 2000, 100000}) {
    const SpreadNetwork whole = spread_network(nodes, 1, true, 0, 1);
    EXPECT_EQ(whole.values.size(), static_cast<std::size_t>(nodes));
    std::size_t factors = 0, variables = 0;
    for (int rank = 0; rank < 6; ++rank) {
      const SpreadNetwork part = spread_network(nodes, 1, true, rank, 6);
      part.values.for_each<Point2>(
          [&](Key key, const Point2& p) { ASSERT_EQ(p.position(), whole.values.at<Point2>(key).position()) << key; });
      factors += part.graph.size();
      variables += part.values.size();
    }
    EXPECT_EQ(variables, whole.values.size());
    EXPECT_EQ(factors, whole.graph.size());
  }
}

}  // namespace
}  // namespace holdfast::program
