#include <gtest/gtest.h>

#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/solvers/incremental/incremental.hpp>
#include <holdfast/testing.hpp>

namespace holdfast {
namespace {

constexpr Agent x('x'), L('L');

using PoseRange = Range<Pose2, Point2>;

IncrementalOptions telling() {
  IncrementalOptions options;
  options.findings = options.report = true;
  return options;
}

void insert_fixed(Incremental& smoother, int k, double px, double py) {
  smoother.insert(x(k), Pose2(px, py, 0));
  smoother.fix(x(k));
}

TEST(IncrementalReport, AMirrorImageArisesOnALineAndGoesWithARangeFromBesideIt) {
  Incremental smoother(telling());
  for (int k = 0; k < 3; ++k) insert_fixed(smoother, k, 2 * k, 0);
  smoother.insert(L(0), Point2(3, 3.5));
  smoother.add(PoseRange{5, 0.1}, {x(0), L(0)});  // the point (3, 4), or (3, -4)
  smoother.add(PoseRange{std::sqrt(17.0), 0.1}, {x(1), L(0)});
  const IncrementalStep& first = smoother.update();
  ASSERT_EQ(first.findings.size(), 1u);
  EXPECT_EQ(first.findings[0].kind, Finding::Kind::mirror_image);
  EXPECT_EQ(first.findings[0].keys, std::vector<Key>{L(0)});
  EXPECT_TRUE(first.gone.empty());

  smoother.add(PoseRange{std::sqrt(17.0), 0.1}, {x(2), L(0)});  // from the same line: nothing new to say
  const IncrementalStep& second = smoother.update();
  EXPECT_TRUE(second.findings.empty());
  EXPECT_TRUE(second.gone.empty());

  insert_fixed(smoother, 3, 3, 1);
  smoother.add(PoseRange{3, 0.1}, {x(3), L(0)});
  const IncrementalStep& third = smoother.update();
  EXPECT_TRUE(third.findings.empty());
  ASSERT_EQ(third.gone.size(), 1u);
  EXPECT_EQ(third.gone[0].keys, std::vector<Key>{L(0)});
}

TEST(IncrementalReport, ARangeAtZeroDistanceIsNamedOnceAndGoesWithTheFactor) {
  Incremental smoother(telling());
  insert_fixed(smoother, 0, 1, 1);
  smoother.insert(L(0), Point2(1, 1));
  smoother.add(Prior<Point2>::from_sigmas(Point2(1, 1), Vector<2>(1, 1)), {L(0)});
  const FactorId range = smoother.add(PoseRange{2, 0.1}, {x(0), L(0)});
  ASSERT_EQ(smoother.update().findings.size(), 1u);
  EXPECT_EQ(smoother.update().findings.size(), 0u);
  smoother.remove(range);
  const IncrementalStep& step = smoother.update();
  ASSERT_EQ(step.gone.size(), 1u);
  EXPECT_EQ(step.gone[0].kind, Finding::Kind::zero_distance);
  EXPECT_EQ(step.gone[0].keys, (std::vector<Key>{L(0), x(0)}));
}

/// Three ranges that agree and one that is 20 m too long, under a loss that redescends.
TEST(IncrementalReport, AnOutlierIsJudgedInTheStepThatBringsIt) {
  Incremental smoother(telling());
  insert_fixed(smoother, 0, 0, 0);
  insert_fixed(smoother, 1, 6, 0);
  insert_fixed(smoother, 2, 3, 9);
  smoother.insert(L(0), Point2(3, 4));
  for (int k = 0; k < 3; ++k) smoother.add(PoseRange{5, 0.1}, {x(k), L(0)}, Cauchy{1});
  for (const MeasurementReport& one : smoother.update().report) EXPECT_EQ(one.verdict, MeasurementReport::Verdict::inlier);
  const FactorId wrong = smoother.add(PoseRange{25, 0.1}, {x(0), L(0)}, Cauchy{1});
  const IncrementalStep& step = smoother.update();
  int judged = 0;
  for (const MeasurementReport& one : step.report) {
    const bool is_wrong = one.id.number == wrong.number;
    EXPECT_EQ(one.verdict, is_wrong ? MeasurementReport::Verdict::outlier : MeasurementReport::Verdict::inlier);
    judged += is_wrong;
    if (is_wrong) {
      EXPECT_NEAR(one.raw.at(0), -20, 0.1);
    }
  }
  EXPECT_EQ(judged, 1);
}

}  // namespace
}  // namespace holdfast
