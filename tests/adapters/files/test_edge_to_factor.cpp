// One edge of each kind, with what it costs worked out by hand; in a Graph and in a Window.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <holdfast/adapters/files/edge_to_factor.hpp>
#include <holdfast/adapters/files/vertex_value.hpp>
#include <holdfast/solvers/window/window.hpp>

#include "tests/graph/files/helpers.hpp"

namespace holdfast::testing {
namespace {

using testing_io::expect_message;

constexpr Agent A('A'), B('B'), L('L'), M('M');

/// Poses A0 (plane) and B0 (space), turned a quarter to the left; points L0 and M0.
Values world() {
  Values values;
  values.insert(A(0), Pose2(1, 2, kPi / 2));
  values.insert(A(1), Pose2(1, 5, kPi / 2));
  values.insert(L(0), Point2(4, 6));
  values.insert(L(1), Point2(4, 2));
  const double half = std::sqrt(0.5);
  values.insert(B(0), Pose3{{1, 2, 3}, Pose3::Rotation(half, 0, 0, half)});
  values.insert(B(1), Pose3{{1, 5, 3}, Pose3::Rotation(half, 0, 0, half)});
  values.insert(M(0), Point3(1, 6, 6));
  values.insert(M(1), Point3(1, 2, 6));
  return values;
}

/// ½ rᵀ I r of this edge alone.
double cost_of(const Measurement& measurement, const Values& values = world(), const Loss& loss = {}) {
  Graph graph;
  edge_to_factor(measurement, values, [&](const auto& factor, auto... keys) { return graph.add(factor, {keys...}, loss); });
  return graph.cost(values);
}

template <int N>
MatrixNoise<N> information(const Vector<N>& diagonal, Format format = Format::G2o) {
  return {Matrix<N, N>(diagonal.asDiagonal()), format};
}

TEST(EdgeToFactor, ARelativePoseIsFromTheFirstToTheSecond) {
  // A1 is 3 m ahead of A0; measured: 2.5 m ahead, 0.1 m to the left.
  const RelativePoseEdge<Pose2> plane{A(0), A(1), Pose2(2.5, 0.1, 0), {}, information<3>({4, 9, 16})};
  EXPECT_NEAR(cost_of(plane), 0.5 * (4 * 0.25 + 9 * 0.01), 1e-12);
  const RelativePoseEdge<Pose3> space{B(0), B(1), Pose3{{2.5, 0.1, 0.2}, {1, 0, 0, 0}}, {}, information<6>({4, 9, 25, 1, 1, 1})};
  EXPECT_NEAR(cost_of(space), 0.5 * (4 * 0.25 + 9 * 0.01 + 25 * 0.04), 1e-12);
}

TEST(EdgeToFactor, ARelativePointIsInTheFrameOfItsPose) {
  // L0 − A0 = (3, 4) in the world, (4, −3) in the pose.
  const RelativePointEdge<Point2> plane{A(0), L(0), Point2(4.5, -3.1), {}, information<2>({4, 9}), {}};
  EXPECT_NEAR(cost_of(plane), 0.5 * (4 * 0.25 + 9 * 0.01), 1e-12);
  const RelativePointEdge<Point3> space{B(0), M(0), Point3(4.5, 0.1, 3.2), {}, information<3>({4, 9, 25}), {}};
  EXPECT_NEAR(cost_of(space), 0.5 * (4 * 0.25 + 9 * 0.01 + 25 * 0.04), 1e-12);
}

TEST(EdgeToFactor, APriorIsInTheWorldItsNoiseInThePose) {
  // 0.5 m off along x of the world, which is the pose's own −y.
  const PriorEdge<Pose2> plane{A(0), Pose2(1.5, 2, kPi / 2), {}, information<3>({4, 9, 16}), {}};
  EXPECT_NEAR(cost_of(plane), 0.5 * 9 * 0.25, 1e-12);
  const PriorEdge<Point2> point{L(0), Point2(4.5, 6.1), {}, information<2>({4, 9}), {}};
  EXPECT_NEAR(cost_of(point), 0.5 * (4 * 0.25 + 9 * 0.01), 1e-12);
  const PriorEdge<Point3> point3{M(0), Point3(1.5, 6.1, 6), {}, information<3>({4, 9, 1}), {}};
  EXPECT_NEAR(cost_of(point3), 0.5 * (4 * 0.25 + 9 * 0.01), 1e-12);
}

TEST(EdgeToFactor, ARangeTakesPosesAndPointsAtBothEnds) {
  // Distances of 3 m between poses, 5 m from pose to point, 4 m between points; measured 1 m more, sigma 0.5 m.
  const double one_metre = 0.5 * std::pow(1 / 0.5, 2);
  for (const auto& [first, second, distance] :
       {std::tuple{A(0), A(1), 3.0}, std::tuple{A(0), L(0), 5.0}, std::tuple{L(0), A(0), 5.0}, std::tuple{L(0), L(1), 4.0},
        std::tuple{B(0), B(1), 3.0}, std::tuple{B(0), M(0), 5.0}, std::tuple{M(0), B(0), 5.0}, std::tuple{M(0), M(1), 4.0}}) {
    EXPECT_NEAR(cost_of(RangeEdge{first, second, distance + 1, 0.25}), one_metre, 1e-12) << first.str() << ' ' << second.str();
    EXPECT_NEAR(cost_of(RangeEdge{first, second, distance, 0.25}), 0, 1e-12) << first.str() << ' ' << second.str();
  }
}

TEST(EdgeToFactor, ARangeBetweenPlaneAndSpaceIsNamed) {
  expect_message<BadType>([] { cost_of(RangeEdge{A(0), B(0), 1, 1}); }, {"A0", "Pose2", "B0", "Pose3", "both in space"});
  expect_message<BadType>([] { cost_of(RangeEdge{M(0), L(0), 1, 1}); }, {"M0", "Point3", "L0", "Point2"});
}

TEST(EdgeToFactor, ARangeToNothingAndToWhatFilesDoNotHaveIsNamed) {
  Values values = world();
  values.insert(A(2), Motion2(0, 0, 0, 0));
  expect_message<BadKey>([&] { cost_of(RangeEdge{A(0), A(9), 1, 1}, values); }, {"A9"});
  expect_message<BadType>([&] { cost_of(RangeEdge{A(0), A(2), 1, 1}, values); }, {"A2", "Motion2", "poses and points"});
}

TEST(EdgeToFactor, TheCallerChoosesTheLossOfEachEdge) {
  const RangeEdge edge{A(0), L(0), 5 + 10, 1};
  EXPECT_NEAR(cost_of(edge, world(), Huber{2}), 0.5 * (2 * 2 * 10 - 4), 1e-12);
}

TEST(EdgeToFactor, AddsToAWindowAsToAGraph) {
  WindowOptions options;
  options.lag = 10;
  Window window(options);
  window.add_state(A(0), 0, Pose2(1, 2, kPi / 2));
  window.add_landmark(L(0), Point2(4, 6));
  const FactorId id = edge_to_factor(RangeEdge{A(0), L(0), 6, 0.25}, window.values(),
                                     [&](const auto& factor, auto... keys) { return window.add(factor, {keys...}); });
  EXPECT_TRUE(window.graph().contains(id));
  EXPECT_NEAR(window.graph().cost(window.values()), 2, 1e-12);
}

TEST(VertexValue, IsTheVariableWhereFilesHaveItsType) {
  Values values = world();
  values.insert(A(2), Motion2(0, 0, 0, 0));
  EXPECT_EQ(std::get<Pose2>(*vertex_value(values, A(1))).p, Vector<2>(1, 5));
  EXPECT_EQ(std::get<Pose3>(*vertex_value(values, B(1))).p, Vector<3>(1, 5, 3));
  EXPECT_EQ(std::get<Point2>(*vertex_value(values, L(1))).value, Vector<2>(4, 2));
  EXPECT_EQ(std::get<Point3>(*vertex_value(values, M(1))).value, Vector<3>(1, 2, 6));
  EXPECT_FALSE(vertex_value(values, A(2)));
  EXPECT_STREQ(type_name(values, A(2)), "Motion2");
  EXPECT_THROW(vertex_value(values, A(9)), BadKey);
}

}  // namespace
}  // namespace holdfast::testing
