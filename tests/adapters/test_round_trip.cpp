// File → graph → file, on every file there is: nothing is lost.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <holdfast/adapters/files/problem.hpp>
#include <holdfast/adapters/files/to_dataset.hpp>
#include <holdfast/factors/between.hpp>
#include <holdfast/factors/position_step.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/graph/files/files.hpp>
#include <sstream>

#include "tests/adapters/data_files.hpp"

namespace holdfast::testing {
namespace {

using ::testing::HasSubstr;

std::string text_of(const Dataset& dataset) { return to_text(dataset, dataset.format); }

TEST(RoundTrip, AFileThroughAGraphIsTheSameFile) {
  int count = 0;
  for (const std::string& file : data_files()) {
    SCOPED_TRACE(file);
    const Dataset dataset = read_dataset(file);
    const Problem problem = make_problem(dataset);
    EXPECT_EQ(problem.factors.size(), dataset.edges.size());
    for (const Vertex& vertex : dataset.vertices) EXPECT_TRUE(problem.start.contains(vertex.key));
    const Dataset back = with_values(dataset, problem.start);
    const bool complete = back.vertices.size() == dataset.vertices.size();
    EXPECT_TRUE(!complete || text_of(back) == text_of(dataset));  // bit by bit, times, FIX and all
    std::istringstream text(text_of(dataset));
    const Problem again = make_problem(parse_dataset(text, file));
    EXPECT_EQ(again.graph.size(), problem.graph.size());
    EXPECT_EQ(again.graph.fixed(), problem.graph.fixed());
    EXPECT_EQ(again.graph.cost(again.start), problem.graph.cost(problem.start));
    ++count;
  }
  if (count == 0) GTEST_SKIP() << kNoFiles;
}

/// A graph alone, without the file it came from: the same cost to rounding, the same keys, edges and fixed variables.
TEST(RoundTrip, AGraphWithoutItsFileComesBackToRounding) {
  for (const std::string& file : data_files()) {
    SCOPED_TRACE(file);
    const Dataset dataset = read_dataset(file);
    const Problem problem = make_problem(dataset);
    const Problem back = make_problem(to_dataset(problem.graph, problem.start, dataset.format));
    EXPECT_EQ(back.graph.size(), problem.graph.size());
    EXPECT_EQ(back.start.keys(), problem.start.keys());
    EXPECT_EQ(back.graph.fixed(), problem.graph.fixed());
    const double cost = problem.graph.cost(problem.start);
    EXPECT_NEAR(back.graph.cost(back.start), cost, 1e-8 * cost + 1e-12);
    if (dataset.format != Format::G2o) continue;
    std::istringstream text(to_g2o(to_dataset(problem.graph, problem.start, Format::G2o)));
    const Problem read_back = make_problem(parse_g2o(text, file));
    EXPECT_NEAR(read_back.graph.cost(read_back.start), cost, 1e-8 * cost + 1e-12);
  }
}

template <class Fn>
std::string message_of(const Fn& fn) {
  try {
    fn();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(RoundTrip, WhatAFileCannotHoldIsNamed) {
  const Key a('x', 0), b('x', 1);
  Values values;
  values.insert(a, Pose2());
  values.insert(b, Pose2(1, 0, 0));
  const auto refusal = [&](auto factor, const Loss& loss) {
    Graph graph;
    graph.add(factor, {a, b}, loss);
    return message_of([&] { to_g2o(to_dataset(graph, values, Format::G2o)); });
  };
  EXPECT_THAT(refusal(PositionStep<Pose2, Pose2>{1}, Squared{}), HasSubstr("PositionStep(x0, x1)"));
  EXPECT_THAT(refusal(Between<Pose2>::from_sigmas(Pose2(), Vector<3>(1, 1, 1)), Huber{2}), HasSubstr("huber:2"));
  EXPECT_THAT(refusal(Range<Pose2, Pose2>{1, 1}, Squared{}), HasSubstr("range x0 x1"));
  values.insert(Key('m', 0), Motion2());
  EXPECT_THAT(refusal(Between<Pose2>::from_sigmas(Pose2(), Vector<3>(1, 1, 1)), Squared{}), HasSubstr("m0, a Motion2"));
}

}  // namespace
}  // namespace holdfast::testing
