// A graph's bytes: back with the same numbers, and refused by name where they say what no graph is.
#include <holdfast/factors/range.hpp>
#include <holdfast/graph/files/binary.hpp>
#include <holdfast/graph/linear_prior.hpp>

#include "tests/graph/files/helpers.hpp"

namespace holdfast {
namespace {

using testing_io::expect_message;

constexpr Agent A('A');

/// A graph of one linear prior, as its bytes; on no variables where there are no `keys`.
std::string one_prior(std::size_t keys, std::int32_t rows) {
  io::ByteWriter out;
  out.put<std::uint64_t>(1).put(std::string_view("Point2")).put<std::int32_t>(2).put<std::uint64_t>(1);  // one pool of one variable
  out.put(A(0)).put(1.0).put(2.0);
  out.put<std::uint64_t>(0);                                                                   // nothing is fixed
  out.put<std::uint64_t>(1).put<std::uint32_t>(0).put<std::uint64_t>(0).put<std::int32_t>(0);  // factor 0 has a name
  out.put<std::uint64_t>(1).put(std::string_view("LinearPrior")).put<std::uint64_t>(0);        // one batch
  out.put<std::int32_t>(0).put(1.0).put(false).put(false).put<std::uint64_t>(1).put(1.0);      // squared, one, weight 1
  out.put<std::uint64_t>(keys);
  for (std::size_t k = 0; k < keys; ++k) out.put(A(0)).put(std::string_view("Point2")).put<std::int32_t>(2).put(0.0).put(0.0);
  out.put<std::int32_t>(rows).put(0.0);
  for (std::int64_t i = 0; i < std::int64_t{rows} * (2 * static_cast<std::int64_t>(keys) + 1); ++i) out.put(i == 0 ? 1.0 : 0.0);
  return out.bytes();
}

/// What the bytes hold, and its cost.
double cost_of(const std::string& bytes) {
  Values().insert(A(0), Point2(0, 0));  // a program knows the types that it inserts
  io::ByteReader in(bytes);
  Graph graph;
  Values values;
  io::read_binary(in, graph, values);
  EXPECT_TRUE(in.at_end());
  EXPECT_EQ(graph.size(), 1u);
  return graph.cost(values);
}

TEST(Binary, HoldsALinearPrior) {
  EXPECT_DOUBLE_EQ(cost_of(one_prior(1, 1)), 0.5);
}  // A = (1 0), b = 0 about x₀ = 0: the point is at (1, 2)

TEST(Binary, RefusesAPriorOfNothing) {
  expect_message<BadFile>([] { cost_of(one_prior(0, 1)); }, {"LinearPrior without variables"});
  expect_message<BadFile>([] { cost_of(one_prior(1, 0)); }, {"LinearPrior without rows"});
}

}  // namespace
}  // namespace holdfast
