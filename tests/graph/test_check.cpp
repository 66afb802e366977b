// The problem check: each finding by name, and no false alarms.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <holdfast/adapters/files/problem.hpp>
#include <holdfast/graph/check.hpp>
#include <holdfast/graph/files/files.hpp>
#include <holdfast/graph/observability.hpp>

#include "tests/problems.hpp"

namespace holdfast {
namespace {

using ::testing::HasSubstr;
using Kind = Finding::Kind;
using Severity = Finding::Severity;

constexpr Agent A('A'), B('B'), L('L');

std::vector<Finding> of_kind(const std::vector<Finding>& findings, Kind kind) {
  std::vector<Finding> some;
  for (const Finding& finding : findings)
    if (finding.kind == kind) some.push_back(finding);
  return some;
}

std::string all_texts(const std::vector<Finding>& findings) {
  std::string text;
  for (const Finding& finding : findings) text += std::string(to_string(finding.kind)) + ": " + finding.text + "\n";
  return text;
}

/// The one finding of this kind; a failure where there is not exactly one.
Finding only(const std::vector<Finding>& findings, Kind kind) {
  const std::vector<Finding> some = of_kind(findings, kind);
  EXPECT_EQ(some.size(), 1u) << to_string(kind) << " among\n" << all_texts(findings);
  return some.empty() ? Finding{} : some.front();
}

Prior<Point2> weak_prior(double x = 0, double y = 0) { return Prior<Point2>::from_sigmas(Point2(x, y), Vector<2>(1, 1)); }

TEST(Doctor, FindsNothingWrongWithGoodProblems) {
  EXPECT_EQ(all_texts(check(testing::slam<Pose2>(1, 12, 0.1).graph, testing::slam<Pose2>(1, 12, 0.1).start)), "");
  const auto space = testing::slam<Pose3>(2, 12, 0.1);
  EXPECT_EQ(all_texts(check(space.graph, space.start)), "");
  const auto balls = testing::range_balls<Point3>(3, 6, Huber{2});
  EXPECT_FALSE(has_errors(check(balls.graph, balls.start)));
  const auto target = testing::tracking<Motion2>(4, 20, 0.1, Huber{2});
  EXPECT_EQ(all_texts(check(target.graph, target.start)), "");
}

TEST(Doctor, EmptyGraph) {
  const auto findings = check(Graph(), Values());
  EXPECT_EQ(only(findings, Kind::empty_graph).severity, Severity::error);
  EXPECT_TRUE(has_errors(findings));
}

TEST(Doctor, UnknownKey) {
  Graph graph;
  graph.add(weak_prior(), {A(0)});
  graph.add(weak_prior(), {A(7)});
  graph.add(weak_prior(1, 1), {A(7)});
  Values values;
  values.insert(A(0), Point2(0, 0));
  const Finding finding = only(check(graph, values), Kind::unknown_key);  // once, not once a factor
  EXPECT_EQ(finding.keys, std::vector<Key>{A(7)});
  EXPECT_EQ(finding.severity, Severity::error);
  for (const char* part : {"Prior(A7)", "Point2"}) EXPECT_THAT(finding.text, HasSubstr(part));
}

TEST(Doctor, WrongType) {
  Graph graph;
  graph.add(weak_prior(), {A(0)});
  Values values;
  values.insert(A(0), Pose3());
  const Finding finding = only(check(graph, values), Kind::wrong_type);
  EXPECT_EQ(finding.keys, std::vector<Key>{A(0)});
  for (const char* part : {"Prior(A0)", "Point2", "Pose3"}) EXPECT_THAT(finding.text, HasSubstr(part));
}

TEST(Doctor, BadValue) {
  Graph graph;
  graph.add(weak_prior(), {A(0)});
  for (const double bad : {static_cast<double>(NAN), static_cast<double>(INFINITY)}) {
    Values values;
    values.insert(A(0), Point2(0, bad));
    const Finding finding = only(check(graph, values), Kind::bad_value);
    EXPECT_EQ(finding.keys, std::vector<Key>{A(0)});
    EXPECT_THAT(finding.text, HasSubstr("A0"));
    EXPECT_EQ(finding.severity, Severity::error);
  }
}

/// Finite at no value at all.
struct LogOfNothing {
  using Variables = variables<Point2>;
  static constexpr int residual_dim = 1;
  static const char* name() { return "LogOfNothing"; }
  Vector<1> operator()(const Point2&, Jacobians<LogOfNothing>* J = nullptr) const {
    if (J != nullptr) J->all.setZero();
    return Vector<1>(std::log(-1.0));
  }
};

TEST(Doctor, BadResidualNamesFactorAndKeys) {
  Graph graph;
  graph.add(weak_prior(), {A(0)});
  graph.add(LogOfNothing{}, {A(0)});
  Values values;
  values.insert(A(0), Point2(0, 0));
  const Finding finding = only(check(graph, values), Kind::bad_residual);
  EXPECT_THAT(finding.text, HasSubstr("LogOfNothing(A0)"));
  EXPECT_EQ(finding.keys, std::vector<Key>{A(0)});  // "the culprits"
}

TEST(Doctor, NothingFree) {
  Graph graph;
  graph.add(weak_prior(), {A(0)});
  graph.fix(A(0));
  Values values;
  values.insert(A(0), Point2(0, 0));
  EXPECT_EQ(only(check(graph, values), Kind::nothing_free).severity, Severity::error);
}

TEST(Doctor, VariableThatNoFactorTouches) {
  Graph graph;
  graph.add(weak_prior(), {A(0)});
  Values values;
  values.insert(A(0), Point2(0, 0));
  values.insert(B(3), Pose2());
  const auto findings = check(graph, values);
  EXPECT_EQ(only(findings, Kind::unconstrained_variable).keys, std::vector<Key>{B(3)});
  EXPECT_FALSE(has_errors(findings));
}

TEST(Doctor, PointWithASingleRangeHasOneFreeDirection) {
  Graph graph;
  graph.add(Range<Point2, Point2>{5, 0.1}, {L(0), A(0)});
  graph.fix(L(0));
  Values values;
  values.insert(L(0), Point2(0, 0));
  values.insert(A(0), Point2(3, 4));
  const auto findings = check(graph, values);
  EXPECT_TRUE(has_errors(findings));
  // Turning about L0 is a rigid motion of the whole, too: either name will do, but there is exactly one.
  EXPECT_EQ(of_kind(findings, Kind::unconstrained_direction).size() + of_kind(findings, Kind::free_gauge).size(), 1u)
      << all_texts(findings);
  EXPECT_THAT(all_texts(findings), HasSubstr("A0"));
}

TEST(Doctor, VelocityThatNobodyMeasures) {
  Graph graph;
  graph.add(HuberMeasurement<Motion2>::of_position({1, 2}, {0, 0}, Matrix<2, 2>(Matrix<2, 2>::Identity())), {A(0)});
  Values values;
  values.insert(A(0), Motion2(0, 0, 0, 0));
  const auto findings = check(graph, values);
  EXPECT_EQ(of_kind(findings, Kind::unconstrained_direction).size(), 2u) << all_texts(findings);
  EXPECT_THAT(all_texts(findings), ::testing::AllOf(HasSubstr("velocity x"), HasSubstr("velocity y")));
}

TEST(Doctor, PoseGraphWithoutAPriorCanMove) {
  auto in_plane = [] {
    Graph graph;
    for (int i = 1; i < 5; ++i) graph.add(Between<Pose2>::from_sigmas(Pose2(1, 0, 0.1), Vector<3>(0.1, 0.1, 0.1)), {A(i - 1), A(i)});
    return graph;
  };
  Values values;
  for (int i = 0; i < 5; ++i) values.insert(A(i), Pose2(i, 0.1 * i, 0.1 * i));
  const Finding finding = only(check(in_plane(), values), Kind::free_gauge);
  for (const char* part : {"translation x", "translation y", "rotation", "5 variables", "agent A"})
    EXPECT_THAT(finding.text, HasSubstr(part));
  Graph fixed = in_plane();
  fixed.fix(A(0));
  EXPECT_EQ(all_texts(check(fixed, values)), "");
}

TEST(Doctor, GaugeInSpaceIsNamedAxisByAxis) {
  Graph graph;
  std::mt19937_64 rng(5);
  Values values;
  for (int i = 0; i < 5; ++i) values.insert(A(i), testing::random_variable<Pose3>(rng));
  for (int i = 1; i < 5; ++i) {
    const Pose3 measured = values.at<Pose3>(A(i - 1)).inverse() * values.at<Pose3>(A(i));
    graph.add(Between<Pose3>::from_sigmas(measured, Vector<6>::Constant(0.1)), {A(i - 1), A(i)});
  }
  const auto findings = check(graph, values);
  const Finding finding = only(findings, Kind::free_gauge);
  for (const char* part : {"translation x", "translation y", "translation z", "rotation x", "rotation y", "rotation z"})
    EXPECT_THAT(finding.text, HasSubstr(part));
  EXPECT_TRUE(of_kind(findings, Kind::unconstrained_direction).empty()) << all_texts(findings);
}

TEST(Doctor, GpsInSpaceLeavesTheRotationAboutTheLine) {
  // Two points with absolute positions and two more hanging on them by ranges in space.
  Graph graph;
  Values values;
  const Point3 anchors[] = {Point3(0, 0, 0), Point3(1, 0, 0)};
  for (int i = 0; i < 2; ++i) {
    values.insert(L(i), anchors[i]);
    graph.fix(L(i));
  }
  values.insert(A(0), Point3(0.5, 1, 0));
  for (int i = 0; i < 2; ++i) graph.add(Range<Point3, Point3>{1, 0.1}, {L(i), A(0)});
  const auto findings = check(graph, values);
  EXPECT_EQ(of_kind(findings, Kind::unconstrained_direction).size() + of_kind(findings, Kind::free_gauge).size(), 1u)
      << all_texts(findings);
}

/// Ties a point in the plane to one in space, and says nothing about either.
struct Acquainted {
  using Variables = variables<Point2, Point3>;
  static constexpr int residual_dim = 1;
  static const char* name() { return "Acquainted"; }
  Vector<1> operator()(const Point2&, const Point3&, Jacobians<Acquainted>* J = nullptr) const {
    if (J != nullptr) J->all.setZero();
    return Vector<1>::Zero();
  }
};

TEST(Doctor, NamesEachMotionOnceWherePlaneAndSpaceMeet) {
  Graph graph;
  Values values;
  for (int k = 0; k < 3; ++k) {
    values.insert(A(k), Point2(k, 0.5 * k * k));
    values.insert(B(k), Point3(k, 1, k * k));
    graph.add(Acquainted{}, {A(k), B(k)});
    if (k > 0) graph.add(Between<Point2>::from_sigmas(Point2(1, 0), Vector<2>(1, 1)), {A(k - 1), A(k)});
    if (k > 0) graph.add(Between<Point3>::from_sigmas(Point3(1, 0, 0), Vector<3>(1, 1, 1)), {B(k - 1), B(k)});
  }
  EXPECT_THAT(only(check(graph, values), Kind::free_gauge).text, HasSubstr("(translation x, translation y, translation z)"));
}

TEST(Doctor, NamesValuesWhoseSquaresOverflow) {
  for (const double far : {1e50, 1e150, 1e200, 1e308}) {
    SCOPED_TRACE(far);
    Graph graph;
    Values values;
    for (int k = 0; k < 3; ++k) values.insert(A(k), Pose2(k == 0 ? 0 : far, 0.1 * k, 0.3 * k));
    values.insert(B(0), Point2(1, 2));
    graph.add(Between<Pose2>::from_sigmas(Pose2(far, 0.1, 0.3), Vector<3>(0.1, 0.1, 0.05)), {A(0), A(1)});
    graph.add(Between<Pose2>::from_sigmas(Pose2(0, 0.1, 0.3), Vector<3>(0.1, 0.1, 0.05)), {A(1), A(2)});
    graph.add(RelativePoint<Pose2, Point2>::from_sigmas(Vector<2>(1, 2), Vector<2>(0.1, 0.1)), {A(0), B(0)});
    const std::vector<Finding> findings = check(graph, values);
    EXPECT_TRUE(has_errors(findings));
    const std::vector<Finding> named = of_kind(findings, Kind::bad_value);
    ASSERT_EQ(named.size(), far > 1e100 ? 2u : 0u) << all_texts(findings);
    if (far < 1e100) continue;
    EXPECT_EQ(named[0].keys, std::vector<Key>{A(1)});
    EXPECT_THAT(named[0].text, HasSubstr("A1 (Pose2)"));
    EXPECT_THAT(named[0].text, HasSubstr("squares of such numbers overflow"));
  }
}

TEST(Doctor, RangeOnlyPairIsFreeToMoveTogether) {
  Graph graph;
  graph.add(Range<Point2, Point2>{5, 0.1}, {A(0), B(0)});
  Values values;
  values.insert(A(0), Point2(0, 0));
  values.insert(B(0), Point2(3, 4));
  const auto findings = check(graph, values);
  const Finding finding = only(findings, Kind::free_gauge);
  for (const char* part : {"translation x", "translation y", "rotation", "agent A", "agent B"}) EXPECT_THAT(finding.text, HasSubstr(part));
  EXPECT_TRUE(of_kind(findings, Kind::unconstrained_direction).empty()) << all_texts(findings);
}

TEST(Doctor, RangesSayNothingAboutHeadings) {
  Graph graph;
  graph.add(Range<Pose2, Pose2>{5, 0.1}, {A(0), B(0)});
  Values values;
  values.insert(A(0), Pose2(0, 0, 1));
  values.insert(B(0), Pose2(3, 4, 2));
  const auto directions = of_kind(check(graph, values), Kind::unconstrained_direction);
  ASSERT_EQ(directions.size(), 2u);
  EXPECT_THAT(directions[0].text, HasSubstr("heading is not constrained"));
}

TEST(Doctor, DisconnectedRobotIsNamed) {
  Graph graph;
  Values values;
  for (const Agent& agent : {A, B})
    for (int i = 0; i < 3; ++i) {
      values.insert(agent(i), Pose2(i, 0, 0));
      if (i == 0) graph.add(Prior<Pose2>::from_sigmas(Pose2(), Vector<3>(1, 1, 1)), {agent(0)});
      if (i > 0) graph.add(Between<Pose2>::from_sigmas(Pose2(1, 0, 0), Vector<3>(1, 1, 1)), {agent(i - 1), agent(i)});
    }
  const auto findings = check(graph, values);
  EXPECT_EQ(of_kind(findings, Kind::disconnected).size(), 2u);
  EXPECT_THAT(all_texts(findings), ::testing::AllOf(HasSubstr("agent A from A0"), HasSubstr("agent B from B0")));
  EXPECT_FALSE(has_errors(findings));  // each has its own prior
}

TEST(Doctor, InactiveRangeBallIsOnlyAWarning) {
  Graph graph;
  graph.add(RangeBall<Point2, Point2>{10, 0.1}, {L(0), A(0)});
  graph.fix(L(0));
  Values values;
  values.insert(L(0), Point2(0, 0));
  values.insert(A(0), Point2(3, 4));  // well inside
  const auto findings = check(graph, values);
  EXPECT_FALSE(has_errors(findings)) << all_texts(findings);
  EXPECT_EQ(of_kind(findings, Kind::unconstrained_direction).size(), 2u);
}

TEST(Doctor, SurvivesAnEmptiedBatch) {
  Graph graph;
  const FactorId id = graph.add(Range<Point2, Point2>{1, 1}, {A(0), A(1)});
  graph.add(weak_prior(), {A(0)});
  graph.remove(id);
  Values values;
  values.insert(A(0), Point2(0, 0));
  EXPECT_EQ(all_texts(check(graph, values)), "");
}

TEST(Doctor, AsksForNoMoreThanItLists) {
  Graph graph;
  Values values;
  for (int i = 0; i < 100; ++i) {
    values.insert(A(i), Pose2(i, 0, 0));
    if (i > 0) graph.add(Range<Pose2, Pose2>{1, 0.1}, {A(i - 1), A(i)});
  }
  const auto findings = check(graph, values);
  EXPECT_TRUE(has_errors(findings));
  EXPECT_LT(findings.size(), 30u);
}

std::string data_path(const std::string& file) {
  const char* chosen = std::getenv("HOLDFAST_DATA");
  return (chosen != nullptr ? std::string(chosen) : std::string(HOLDFAST_SOURCE_DIR) + "/../shared/data") + "/" + file;
}

class DoctorOnData : public ::testing::TestWithParam<const char*> {};

TEST_P(DoctorOnData, RaisesNoFalseAlarm) {
  const std::string path = data_path(GetParam());
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there; set HOLDFAST_DATA";
  const Dataset data = read_dataset(path);
  for (const auto start : {ProblemOptions::Start::file, ProblemOptions::Start::odometry}) {
    const Problem problem = make_problem(data, {Huber{2}, start, 0});
    const auto findings = check(problem.graph, problem.start);
    EXPECT_EQ(all_texts(findings), "");
  }
}

std::string file_label(const ::testing::TestParamInfo<const char*>& info) { return std::filesystem::path(info.param).stem().string(); }

INSTANTIATE_TEST_SUITE_P(Files, DoctorOnData,
                         ::testing::Values("range/plaza2.pyfg", "range/tiers.pyfg", "range/mrclam5a.pyfg", "range/single_drone.pyfg",
                                           "range/goats_14.pyfg", "pose_graph/intel.g2o", "pose_graph/MIT.g2o", "pose_graph/M3500.g2o",
                                           "pose_graph/CSAIL.g2o", "pose_graph/tinyGrid3D.g2o", "pose_graph/smallGrid3D.g2o",
                                           "pose_graph/sphere2500.g2o"),
                         file_label);

}  // namespace
}  // namespace holdfast
