#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <holdfast/factors/between.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/factors/von_mises_bearing.hpp>
#include <holdfast/graph/check.hpp>
#include <holdfast/graph/mirror.hpp>

namespace holdfast {
namespace {

using ::testing::HasSubstr;
constexpr Agent P('P'), L('L'), A('A');

struct Problem {
  Graph graph;
  Values values;
  void anchor(Key key, const Point3& p) {
    values.insert(key, p);
    graph.fix(key);
  }
  void anchor(Key key, const Point2& p) {
    values.insert(key, p);
    graph.fix(key);
  }
};

/// Four anchors under the ceiling, a point below it.
Problem hall(double last_height = 3) {
  Problem problem;
  problem.anchor(L(0), Point3(0, 0, 3));
  problem.anchor(L(1), Point3(10, 0, 3));
  problem.anchor(L(2), Point3(10, 8, 3));
  problem.anchor(L(3), Point3(0, 8, last_height));
  problem.values.insert(P(0), Point3(4, 3, 1));
  for (int i = 0; i < 4; ++i) {
    const double d = (problem.values.at<Point3>(P(0)).value - problem.values.at<Point3>(L(i)).value).norm();
    problem.graph.add(Range<Point3, Point3>{d, 0.1}, {P(0), L(i)});
  }
  return problem;
}

TEST(MirrorImages, AnchorsInOnePlane) {
  const Problem problem = hall();
  const std::vector<MirrorImage> found = mirror_images(problem.graph, problem.values);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].points, std::vector<Key>{P(0)});
  EXPECT_EQ(found[0].anchors.size(), 4u);
  const Values other = mirrored(problem.values, found[0]);
  EXPECT_LT((other.at<Point3>(P(0)).value - Vector<3>(4, 3, 5)).norm(), 1e-9);  // as high above the ceiling as it was below
  EXPECT_NEAR(problem.graph.cost(other), problem.graph.cost(problem.values), 1e-9);
}

TEST(MirrorImages, AnAnchorOffThePlaneTells) {
  const Problem problem = hall(0);
  EXPECT_TRUE(mirror_images(problem.graph, problem.values).empty());
}

TEST(MirrorImages, AStartInThePlaneSaysItAsWell) {
  Problem problem = hall();
  problem.values.update(P(0), Point3(4, 3, 3));
  EXPECT_EQ(mirror_images(problem.graph, problem.values).size(), 1u);
}

TEST(MirrorImages, TwoAnchorsInThePlaneAreOnALine) {
  Problem problem;
  problem.anchor(L(0), Point2(0, 0));
  problem.anchor(L(1), Point2(10, 0));
  problem.values.insert(P(0), Point2(3, 4));
  problem.values.insert(P(1), Point2(6, 5));
  problem.graph.add(Range<Point2, Point2>{5, 0.1}, {P(0), L(0)});
  problem.graph.add(Range<Point2, Point2>{8, 0.1}, {P(0), L(1)});
  problem.graph.add(Range<Point2, Point2>{3, 0.1}, {P(0), P(1)});
  problem.graph.add(Range<Point2, Point2>{6.4, 0.1}, {P(1), L(1)});
  const std::vector<MirrorImage> found = mirror_images(problem.graph, problem.values);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].points, (std::vector<Key>{P(0), P(1)}));
  EXPECT_LT((mirrored(problem.values, found[0]).at<Point2>(P(0)).value - Vector<2>(3, -4)).norm(), 1e-12);
}

TEST(MirrorImages, ARobotOnALineAndItsBeacon) {
  Problem problem;
  for (int i = 0; i < 3; ++i) {
    problem.values.insert(A(i), Pose2(2.0 * i, 0, 0));
    problem.graph.fix(A(i));
  }
  problem.values.insert(L(0), Point2(3, 4));
  for (int i = 0; i < 3; ++i) problem.graph.add(Range<Pose2, Point2>{Vector<2>(3 - 2.0 * i, 4).norm(), 0.1}, {A(i), L(0)});
  EXPECT_EQ(mirror_images(problem.graph, problem.values).size(), 1u);
  problem.graph.add(VonMisesBearingBody<Pose2, Point2>{Vector<2>(0.6, 0.8), 400}, {A(0), L(0)});  // a bearing tells left from right
  EXPECT_TRUE(mirror_images(problem.graph, problem.values).empty());
}

TEST(MirrorImages, APriorHoldsASide) {
  Problem problem = hall();
  problem.graph.add(Prior<Point3>::from_sigmas(Point3(4, 3, 1), Vector<3>(10, 10, 0.5)), {P(0)});
  EXPECT_TRUE(mirror_images(problem.graph, problem.values).empty());
}

TEST(MirrorImages, TheCheckSaysSo) {
  const Problem problem = hall();
  const std::vector<Finding> findings = check(problem.graph, problem.values);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].kind, Finding::Kind::mirror_image);
  EXPECT_EQ(findings[0].severity, Finding::Severity::warning);
  EXPECT_THAT(findings[0].text, HasSubstr("P0 fits as well on the other side of the plane of L0, L1, L2, L3"));
}

TEST(Merged, ThreeHundredEqualFindingsAreOne) {
  Problem problem = hall(0);
  for (int i = 0; i < 300; ++i) problem.values.insert(A(i), Point3(0, 0, 0));
  const std::vector<Finding> findings = check(problem.graph, problem.values);
  EXPECT_EQ(findings.size(), 300u);
  const std::vector<Finding> one = merged(findings);
  ASSERT_EQ(one.size(), 1u);
  EXPECT_EQ(one[0].keys.size(), 300u);
  EXPECT_THAT(one[0].text, HasSubstr("A0: no factor touches it"));
  EXPECT_THAT(one[0].text, HasSubstr("and the same 299 times more: A1, A2, "));
  EXPECT_THAT(one[0].text, HasSubstr(" and 291 more"));
}

TEST(Merged, AFewStayAsTheyAre) {
  Problem problem = hall(0);
  for (int i = 0; i < 3; ++i) problem.values.insert(A(i), Point3(0, 0, 0));
  EXPECT_EQ(merged(check(problem.graph, problem.values)).size(), 3u);
}

}  // namespace
}  // namespace holdfast
