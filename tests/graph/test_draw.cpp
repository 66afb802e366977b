// The DOT text of a small graph.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <holdfast/graph/draw.hpp>

#include "tests/problems.hpp"

namespace holdfast {
namespace {

constexpr Agent A('A'), L('L');

TEST(Draw, IsAGraphOfCirclesAndBoxes) {
  Graph graph;
  graph.add(Range<Pose2, Point2>{5, 0.1}, {A(1), L(0)});
  graph.fix(L(0));
  EXPECT_EQ(to_dot(graph),
            "graph holdfast {\n"
            "  \"A1\" [shape=circle];\n"
            "  \"L0\" [shape=circle, style=filled];\n"
            "  factor0 [shape=box, label=\"Range\"];\n"
            "  factor0 -- \"A1\";\n"
            "  factor0 -- \"L0\";\n"
            "}\n");
}

/// A factor without a name() is called by its C++ type, which may hold anything.
struct Quoted {
  using Variables = variables<Point2>;
  static constexpr int residual_dim = 1;
  static const char* name() { return "a \"b\" \\"; }
  Vector<1> operator()(const Point2& x, Jacobians<Quoted>* J = nullptr) const {
    if (J != nullptr) J->all << 1, 0;
    return Vector<1>(x.x());
  }
};

TEST(Draw, EscapesWhatDotWouldRead) {
  Graph graph;
  graph.add(Quoted{}, {A(1)});
  EXPECT_THAT(to_dot(graph), ::testing::HasSubstr("label=\"a \\\"b\\\" \\\\\""));
}

}  // namespace
}  // namespace holdfast
