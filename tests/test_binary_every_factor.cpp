// Every factor of the library and a user's own, saved and read back: the same residuals, bit by bit.
#include <gtest/gtest.h>

#include <holdfast/graph/files/binary.hpp>

#include "tests/draws.hpp"

namespace holdfast::testing {
namespace {

TEST(EveryFactor, ComesBackFromItsBytes) {
  std::mt19937_64 rng(51);
  for (int instance = 0; instance < 3; ++instance)
    for (const Draw& draw : every_draw(rng)) {
      SCOPED_TRACE(draw.label);
      Graph graph, again;
      Values values = draw.values(rng), same;
      draw.add(graph, Huber{2}, 0.7);
      io::ByteWriter out;
      io::write_binary(out, graph, values);
      io::ByteReader in(out.bytes());
      io::read_binary(in, again, same);
      EXPECT_TRUE(in.at_end());
      EXPECT_EQ(again.cost(same), graph.cost(values));
      const FactorId id = graph.id_of(0, 0);
      for (int state = 0; state < 5; ++state) {
        EXPECT_EQ(again.residual(id, values), graph.residual(id, values));
        EXPECT_EQ(again.cost(values), graph.cost(values));
        values = draw.values(rng);
      }
    }
}

}  // namespace
}  // namespace holdfast::testing
