// What people see of variables, values, graphs: exact texts, since they are short.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <holdfast/graph/print.hpp>
#include <iomanip>
#include <iostream>

#include "tests/problems.hpp"

namespace holdfast {
namespace {

constexpr Agent A('A'), L('L');

template <class T>
std::string printed(const T& what) {
  std::ostringstream out;
  out << what;
  return out.str();
}

TEST(Print, OfAVariableIsItsNameAndNumbers) {
  EXPECT_EQ(printed(Scalar(0.25)), "Scalar(0.25)");
  EXPECT_EQ(printed(Motion2(1, 2, 3, 4)), "Motion2(1, 2, 3, 4)");
  EXPECT_EQ(printed(Pose2(1, 2, 0.5)), "Pose2(1, 2, 0.5)");
  EXPECT_EQ(printed(Pose3::from_roll_pitch_yaw({1, 2, 3}, 0.1, 0.25, -0.5)), "Pose3(1, 2, 3, 0.1, 0.25, -0.5)");
}

TEST(Print, DoesNotMindWhatTheStreamWasSetTo) {
  std::ostringstream out;
  out << std::fixed << std::setprecision(1) << Point2(0.25, 1e9) << " " << 0.25;
  EXPECT_EQ(out.str(), "Point2(0.25, 1e+09) 0.2");
}

/// A type of one's own, with a way to print it and without.
struct Plain {
  static constexpr int dim = 2;
  double a = 1, b = 2;
  static const char* name() { return "Plain"; }
};
struct Own : Plain {
  static const char* name() { return "Own"; }
};
std::ostream& operator<<(std::ostream& out, const Own&) { return out << "own text"; }

TEST(Print, OfATypeOfOnesOwn) {
  std::ostringstream out;
  detail::print_variable(out, Plain{});
  detail::print_variable(out, Own{});
  EXPECT_EQ(out.str(), "Plain(1, 2)own text");
}

TEST(Print, OfValuesIsALineAVariable) {
  Values values;
  EXPECT_EQ(printed(values), "Values: 0 variables\n");
  values.insert(L(0), Point2(3, 4));
  values.insert(A(1), Pose2(1, 2, 0.5));
  EXPECT_EQ(printed(values), "Values: 2 variables\n  A1  Pose2(1, 2, 0.5)\n  L0  Point2(3, 4)\n");
}

TEST(Print, OfAGraphIsALineAFactor) {
  Graph graph;
  graph.add(Range<Pose2, Point2>{5, 0.1}, {A(1), L(0)}, Huber{2}, 0.5);
  graph.add(Prior<Pose2>::from_sigmas(Pose2(), {1, 1, 1}), {A(1)});
  graph.fix(L(0));
  EXPECT_EQ(printed(graph), "Graph: 2 factors on 2 variables, 1 fixed\n  Range(A1, L0), loss huber:2, weight 0.5\n  Prior(A1)\n");
  EXPECT_EQ(printed(Graph()), "Graph: 0 factors on 0 variables\n");
}

TEST(Print, EndsAfterTwentyLines) {
  Values values;
  Graph graph;
  for (int i = 0; i < 1000; ++i) {
    values.insert(A(i), Point2(i, 0));
    graph.add(Prior<Point2>::from_sigmas(Point2(0, 0), {1, 1}), {A(i)});
  }
  for (const std::string& text : {printed(values), printed(graph)}) {
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 22) << text;
    EXPECT_THAT(text, ::testing::EndsWith("  … 980 more\n"));
  }
}

TEST(Print, OfASummaryIsItsText) {
  Summary summary;
  summary.termination = Termination::converged;
  EXPECT_EQ(printed(summary), summary.str());
}

}  // namespace
}  // namespace holdfast
