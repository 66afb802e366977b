// The kinds of files that people have: each of ../shared/cases gives its right value (its README says which). The files stay there.
#include <gtest/gtest.h>

#include <algorithm>
#include <holdfast/adapters/files/convert.hpp>
#include <holdfast/adapters/files/problem.hpp>
#include <holdfast/adapters/files/report.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/von_mises_bearing.hpp>
#include <holdfast/graph/check.hpp>
#include <holdfast/graph/files/tum.hpp>
#include <holdfast/solvers/table.hpp>

#include "tests/graph/files/helpers.hpp"

namespace holdfast {
namespace {

using namespace testing_io;

constexpr Agent x('x');

std::string case_path(const std::string& file) { return data_directory() + "/../cases/" + file; }

#define NEED_CASE(file)                                                      \
  if (data_directory().empty() || !std::filesystem::exists(case_path(file))) \
  GTEST_SKIP() << "no " << (file) << " in ../cases beside HOLDFAST_DATA"

struct Answer {
  Summary summary;
  Values values;
  double cost = 0;
  Vector<2> at(Key key) const {
    return values.contains<Pose2>(key) ? values.at<Pose2>(key).p : Vector<2>(values.at<Pose3>(key).p.head<2>());
  }
};

Answer solved(const Dataset& data, const ProblemOptions& how = {}) {
  Problem problem = make_problem(data, how);
  Options options;
  options.cost_tolerance = 1e-14;
  Answer answer;
  answer.values = problem.start;
  answer.summary = make_backend("irls", options)->solve(problem.graph, answer.values);
  answer.cost = problem.graph.cost(answer.values);
  EXPECT_TRUE(answer.summary.usable()) << answer.summary.str();
  return answer;
}

template <class E>
std::vector<const E*> edges_of(const Dataset& data) {
  std::vector<const E*> all;
  for (const Edge& edge : data.edges)
    if (const auto* one = std::get_if<E>(&edge.measurement)) all.push_back(one);
  return all;
}

std::vector<Finding> of_kind(const std::vector<Finding>& findings, Finding::Kind kind) {
  std::vector<Finding> found;
  std::copy_if(findings.begin(), findings.end(), std::back_inserter(found), [&](const Finding& one) { return one.kind == kind; });
  return found;
}

/// What every case must do: the same text comes back, and the dataset.
void expect_round_trip(const std::string& file, const ReadOptions& options = {}) {
  const Dataset data = read_dataset(case_path(file), options);
  std::istringstream in(written(data));
  expect_same(data, parse_dataset(in, "again", data.format, options));
}

TEST(Cases, GpsWithZeroRotation) {
  NEED_CASE("gps_zero_rotation.g2o");
  const Dataset data = read_dataset(case_path("gps_zero_rotation.g2o"));
  Dataset regular = data;
  for (Edge& edge : regular.edges)
    if (auto* prior = std::get_if<PriorEdge<Pose3>>(&edge.measurement)) prior->noise.written.diagonal().tail<3>().setConstant(1e-9);
  const Answer answer = solved(data), expected = solved(regular);
  for (int i = 0; i < 4; ++i) EXPECT_LT((answer.values.at<Pose3>(x(i)).p - expected.values.at<Pose3>(x(i)).p).norm(), 1e-6) << i;
  EXPECT_LT((answer.values.at<Pose3>(x(0)).p - Vector<3>(100, 200, 50)).norm(), 1e-4);
  expect_round_trip("gps_zero_rotation.g2o");
}

TEST(Cases, PlanarRobotInSpace) {
  NEED_CASE("planar_zero.g2o");
  const Dataset data = read_dataset(case_path("planar_zero.g2o"));
  const Answer answer = solved(data);
  for (int i = 0; i < 4; ++i) EXPECT_LT(std::abs(answer.values.at<Pose3>(x(i)).p.z()), 1e-9) << i;
  EXPECT_NEAR(answer.at(x(3)).x(), 3, 0.01);  // three steps of (1, 0.1) and a closure of (3, 0) that disagree by 0.3 m
  EXPECT_LT(answer.at(x(3)).y(), 0.3);
  const Problem problem = make_problem(data);
  // z, roll and pitch of the three poses that nothing holds.
  EXPECT_EQ(of_kind(check(problem.graph, problem.start), Finding::Kind::unconstrained_direction).size(), 9u);
  expect_round_trip("planar_zero.g2o");
}

TEST(Cases, PositionPriorsInSpace) {
  NEED_CASE("gps_priorxyz.g2o");
  const Dataset data = read_dataset(case_path("gps_priorxyz.g2o"));
  EXPECT_EQ(edges_of<PositionEdge<Point3>>(data).size(), 4u);
  EXPECT_TRUE(data.unknown.empty());
  const Answer answer = solved(data);
  for (const auto* position : edges_of<PositionEdge<Point3>>(data))
    EXPECT_LT((answer.values.at<Pose3>(position->key).p - position->measured.value).norm(), 1e-4) << position->key.str();
  EXPECT_LT(answer.cost, 1e-6);
  EXPECT_NE(use_report(data).find("4 position priors"), std::string::npos) << use_report(data);
  expect_round_trip("gps_priorxyz.g2o");
}

TEST(Cases, PositionPriorsInThePlane) {
  NEED_CASE("gps_prior_se2_xy.g2o");
  const Dataset data = read_dataset(case_path("gps_prior_se2_xy.g2o"));
  const Answer answer = solved(data);
  EXPECT_LT((answer.at(x(2)) - Vector<2>(110, 210)).norm(), 1e-6);
  EXPECT_LT(answer.cost, 1e-12);
  EXPECT_EQ(use_report(data), "3 odometry edges, 1 loop closure, 4 position priors");
  expect_round_trip("gps_prior_se2_xy.g2o");
}

TEST(Cases, SymbolsOfGtsam) {
  NEED_CASE("gtsam_symbols.g2o");
  const Dataset data = read_dataset(case_path("gtsam_symbols.g2o"));
  const Answer answer = solved(data);
  EXPECT_LT((answer.at(Key('a', 3)) - Vector<2>(3.3, 0)).norm(), 1e-6);
  EXPECT_LT((answer.at(Key('b', 0)) - Vector<2>(0, 5)).norm(), 1e-6);
  EXPECT_EQ(use_report(data), "6 odometry edges, 1 loop closure");
  expect_round_trip("gtsam_symbols.g2o");
}

TEST(Cases, LandmarksNumberedApart) {
  NEED_CASE("gtsam_landmark_ids.g2o");
  const Dataset data = read_dataset(case_path("gtsam_landmark_ids.g2o"));
  const Answer answer = solved(data);
  EXPECT_LT((answer.values.at<Point3>(Key('l', 0)).value - Vector<3>(2, 1, 0)).norm(), 1e-9);
  EXPECT_LT((answer.values.at<Pose3>(x(1)).p - Vector<3>(1, 0, 0)).norm(), 1e-9);
  EXPECT_EQ(written(data), content(case_path("gtsam_landmark_ids.g2o")));
}

TEST(Cases, InformationOfTheFullAngle) {
  NEED_CASE("gtsam_information.g2o");
  const Dataset half = read_dataset(case_path("gtsam_information.g2o"));
  ReadOptions gtsam;
  gtsam.full_angle = true;
  const Dataset full = read_dataset(case_path("gtsam_information.g2o"), gtsam);
  // g2o counts half angles: the same information of full angles is 4 times as much to it.
  Dataset scaled = half;
  for (Edge& edge : scaled.edges) {
    auto& pose = std::get<RelativePoseEdge<Pose3>>(edge.measurement);
    pose.noise.written.bottomRightCorner<3, 3>() *= 4;
    pose.noise.written.topRightCorner<3, 3>() *= 2;
    pose.noise.written.bottomLeftCorner<3, 3>() *= 2;
  }
  const Answer a = solved(full), b = solved(scaled), g2o = solved(half);
  EXPECT_NEAR(a.cost, b.cost, 1e-9 * b.cost);
  double rms = 0;
  int n = 0;
  for (Key key : a.values.keys()) {
    EXPECT_LT((a.values.at<Pose3>(key).p - b.values.at<Pose3>(key).p).norm(), 1e-6);
    rms += (a.values.at<Pose3>(key).p - g2o.values.at<Pose3>(key).p).squaredNorm(), ++n;
  }
  EXPECT_NEAR(std::sqrt(rms / n), 0.07, 0.01);  // what reading GTSAM's file as g2o's costs
  expect_round_trip("gtsam_information.g2o", gtsam);
}

TEST(Cases, OdometryWrittenBackwards) {
  NEED_CASE("reversed_odometry.g2o");
  const Dataset data = read_dataset(case_path("reversed_odometry.g2o"));
  const std::string report = use_report(data);
  EXPECT_NE(report.find("odometry edges (written backwards)"), std::string::npos) << report;
  const std::vector<bool> odometry = odometry_edges(data);
  for (std::size_t i = 0; i < odometry.size(); ++i) {
    const auto& edge = std::get<RelativePoseEdge<Pose2>>(data.edges[i].measurement);
    EXPECT_EQ(odometry[i], edge.first.step() == edge.second.step() + 1) << describe(data.edges[i]);
  }
  // false_loops.g2o is the same forwards. An information is of the deviation in the frame of the edge's second pose, so that backwards it
  // means another noise: the answers agree to centimetres, not to rounding, where the loss lets go of the false loops, and under Huber both
  // are near the truth, a square of 10 m. (As loops under the loss they ended 4.5 m off.)
  const Dataset forwards = read_dataset(case_path("false_loops.g2o"));
  const Answer a = solved(data, {Cauchy{1}}), b = solved(forwards, {Cauchy{1}});
  for (int i = 0; i < 40; ++i) EXPECT_LT((a.at(x(i)) - b.at(x(i))).norm(), 0.1) << i;
  for (const Dataset* one : {&data, &forwards}) {
    const Answer answer = solved(*one, {Huber{2}});
    const Vector<2> corners[]{{0, 0}, {10, 0}, {10, 10}, {0, 10}};
    for (int k = 0; k < 4; ++k) EXPECT_LT((answer.at(x(10 * k)) - corners[k]).norm(), 0.6) << k;
  }
}

TEST(Cases, SeamsOfSessionsAreNoOdometry) {
  NEED_CASE("seam.g2o");
  for (const char* file : {"seam.g2o", "not_seam.g2o"})
    for (const Loss& loss : {Loss(Cauchy{1}), Loss(Tukey{4})}) {
      const Dataset data = read_dataset(case_path(file));
      EXPECT_EQ(use_report(data), "10 odometry edges, 4 loop closures") << file;
      EXPECT_LT((solved(data, {loss}).at(x(11)) - Vector<2>(5, 3)).norm(), 0.01) << file << ' ' << loss.str();
    }
  const Dataset data = read_dataset(case_path("seam.g2o"));
  const auto count = [](const std::vector<bool>& all) { return std::count(all.begin(), all.end(), true); };
  EXPECT_EQ(count(odometry_edges(data, odometry_rule("none"))), 0);
  EXPECT_EQ(count(odometry_edges(data, odometry_rule("EDGE_SE2"))), 14);
  expect_message<BadOption>([&] { odometry_edges(data, odometry_rule("ODOMETRY")); }, {"'ODOMETRY'", "there are: EDGE_SE2"});
}

TEST(Cases, SwitchesStandUnderALoss) {
  NEED_CASE("switchable.g2o");
  const Dataset data = read_dataset(case_path("switchable.g2o"));
  EXPECT_EQ(edges_of<RelativePoseEdge<Pose2>>(data).size(), 7u);
  EXPECT_EQ(use_report(data),
            "5 odometry edges, 2 loop closures (with a switch or mixture, under the loss instead); 1 line of VERTEX_SWITCH, 1 line of "
            "EDGE_SWITCH_PRIOR kept, not used");
  const Problem problem = make_problem(data, {Cauchy{1}});
  EXPECT_EQ(problem.graph.size(), 7u);
  for (const std::size_t edge : {5, 6}) {
    const Graph::Place& place = problem.graph.place(problem.factors[edge]);
    EXPECT_EQ(problem.graph.batches()[place.batch]->loss(place.index).str(), Loss(Cauchy{1}).str());
  }
  EXPECT_EQ(written(data), content(case_path("switchable.g2o")));
}

TEST(Cases, Bearings) {
  NEED_CASE("bearing.g2o");
  const Dataset data = read_dataset(case_path("bearing.g2o"));
  const Answer answer = solved(data);
  EXPECT_LT((answer.values.at<Point2>(x(10)).value - Vector<2>(1, 3)).norm(), 0.1);
  std::size_t bearings = 0;
  make_problem(data).graph.for_each_batch<VonMisesBearingBody<Pose2, Point2>>(
      [&](const auto& batch) { bearings += static_cast<std::size_t>(batch.size()); });
  EXPECT_EQ(bearings, 3u);
  EXPECT_EQ(written(data), content(case_path("bearing.g2o")));
}

TEST(Cases, SensorOffset) {
  NEED_CASE("sensor_offset.g2o");
  const Dataset data = read_dataset(case_path("sensor_offset.g2o"));
  const Answer answer = solved(data);
  EXPECT_LT((answer.values.at<Point3>(x(5)).value - Vector<3>(2, 1, 0)).norm(), 1e-6);
  EXPECT_LT(answer.cost, 1e-12);
  EXPECT_EQ(written(data), content(case_path("sensor_offset.g2o")));
}

TEST(Cases, DataLinesStayWhereTheyStood) {
  NEED_CASE("data_lines.g2o");
  const Dataset data = read_dataset(case_path("data_lines.g2o"));
  EXPECT_EQ(written(data), content(case_path("data_lines.g2o")));
}

TEST(Cases, FixOfNoVertex) {
  NEED_CASE("fix0.g2o");
  const Dataset data = read_dataset(case_path("fix0.g2o"));
  const std::vector<Finding> findings = of_kind(check(data), Finding::Kind::unknown_fixed);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_NE(findings[0].text.find("FIX 0 names no vertex"), std::string::npos) << findings[0].text;
  const Problem problem = make_problem(data);
  EXPECT_EQ(problem.graph.fixed().size(), 1u);
  EXPECT_TRUE(problem.graph.is_fixed(x(1)));
}

TEST(Cases, EqualTimes) {
  NEED_CASE("equal_times.pyfg");
  const Dataset data = read_dataset(case_path("equal_times.pyfg"));
  const std::vector<Finding> findings = of_kind(check(data), Finding::Kind::bad_time);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_NE(findings[0].text.find("A3 after A2"), std::string::npos) << findings[0].text;
  const TemporaryDirectory directory;
  write_tum_directory(directory / "out", vertex_start(data), vertex_times(data));
  std::istringstream lines(content(directory / "out/A.tum"));
  double last = 0;
  int n = 0;
  for (std::string line; std::getline(lines, line); ++n) {
    const double time = std::stod(line);
    EXPECT_GT(time, last) << line;
    last = time;
  }
  EXPECT_EQ(n, 5);
}

TEST(Cases, Edge2ByRows) {
  NEED_CASE("edge2_by_rows.graph");
  expect_message<BadFile>([] { read_dataset(case_path("edge2_by_rows.graph")); }, {"line 4", "row by row", "--toro-order rows"});
  ReadOptions options;
  options.toro_rows = true;
  const Dataset data = read_dataset(case_path("edge2_by_rows.graph"), options);
  const Matrix<3, 3> expected = Vector<3>(100, 100, 400).asDiagonal();
  EXPECT_EQ(edges_of<RelativePoseEdge<Pose2>>(data)[0]->noise.written, expected);
  EXPECT_EQ(written(data), content(case_path("edge2_by_rows.graph")));
  solved(data);
}

TEST(Cases, AStartInThePlaneOfAllAnchorsIsLeft) {
  NEED_CASE("coplanar_in_plane.pyfg");
  const Problem problem = make_problem(read_dataset(case_path("coplanar_in_plane.pyfg")));
  Options options;
  options.second_order = true;
  for (const char* name : {"irls", "nesterov"}) {
    Values values = problem.start;
    const Summary end = make_backend(name, options)->solve(problem.graph, values);
    EXPECT_EQ(end.minimum, Minimum::left_saddle) << name << ": " << end.str();
    EXPECT_LT(end.cost, 1e-9) << name;
  }
}

TEST(Cases, RobotsOnOneSpotMoveApartWhereOneOfThemMay) {
  NEED_CASE("pose_on_pose.pyfg");
  Problem problem = make_problem(read_dataset(case_path("pose_on_pose.pyfg")));
  // The second robot's start is known to 10 m: 5 m away it costs half of (5 / 10)², and all four ranges fit.
  for (std::size_t b = 0; b < problem.graph.batches().size(); ++b)
    for (int i = problem.graph.batches()[b]->size() - 1; i >= 0; --i)
      if (problem.graph.batches()[b]->arity() == 1 && problem.graph.batches()[b]->keys(i)[0] == Key('B', 0))
        problem.graph.remove(problem.graph.id_of(static_cast<int>(b), i));
  problem.graph.add(Prior<Pose2>::from_sigmas(Pose2(), Vector<3>(10, 10, 0.01)), {Key('B', 0)});
  problem.graph.fix(Key('A', 0));
  EXPECT_NEAR(problem.graph.cost(problem.start), 5000, 1e-9);
  Options options;
  options.second_order = true;
  const Summary end = make_backend("irls", options)->solve(problem.graph, problem.start);
  EXPECT_EQ(end.minimum, Minimum::left_saddle) << end.str();
  EXPECT_NEAR(end.cost, 0.125, 1e-4);
}

TEST(Cases, WhatNothingHolds) {
  NEED_CASE("two_sessions.g2o");
  NEED_CASE("one_anchor.pyfg");
  const Problem sessions = make_problem(read_dataset(case_path("two_sessions.g2o")));
  const std::vector<Finding> free = of_kind(check(sessions.graph, sessions.start), Finding::Kind::free_gauge);
  ASSERT_EQ(free.size(), 1u);
  EXPECT_EQ(free[0].keys, std::vector<Key>{x(100)});
  const Problem anchor = make_problem(read_dataset(case_path("one_anchor.pyfg")));
  EXPECT_EQ(of_kind(check(anchor.graph, anchor.start), Finding::Kind::free_gauge).size(), 1u);
}

TEST(Cases, NoStartAtAll) {
  NEED_CASE("all_zero.pyfg");
  const Problem problem = make_problem(read_dataset(case_path("all_zero.pyfg")));
  const Finding stuck = zero_distance(problem.graph, problem.start);
  EXPECT_EQ(stuck.keys.size(), 8u);
  EXPECT_NE(stuck.text.find("15 factors stand at zero distance"), std::string::npos) << stuck.text;
}

// ---- kinds that have no file in ../shared/cases

TEST(Kinds, AnIndefiniteMatrixIsRefusedOrRepairedByName) {
  const std::string text = "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 1 2 1 0 0 1 0 0 1 0 -3\nEDGE_SE2 2 3 1 0 0 1 2 0 1 0 1\n";
  expect_message<BadFile>([&] { parsed(text, Format::G2o); }, {"line 2", "smallest eigenvalue is -3", "--indefinite repair"});
  ReadOptions options;
  options.repair = true;
  std::istringstream in(text);
  const Dataset data = parse_dataset(in, "a.g2o", Format::G2o, options);
  ASSERT_EQ(data.repairs.size(), 2u);
  EXPECT_EQ(data.repairs[0].line, 2u);
  EXPECT_NEAR(data.repairs[1].smallest, -1, 1e-12);
  // diag(1, 1, −3): the nearest is diag(1, 1, 0), 3 away of √11.
  EXPECT_NEAR(data.repairs[0].moved, 3 / std::sqrt(11), 1e-12);
  Matrix<3, 3> nearest;
  nearest << 1.5, 1.5, 0, 1.5, 1.5, 0, 0, 0, 1;
  EXPECT_LT((edges_of<RelativePoseEdge<Pose2>>(data)[2]->noise.written - nearest).norm(), 1e-12);
  const std::vector<Finding> findings = of_kind(check(data), Finding::Kind::repaired_noise);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_NE(findings[0].text.find("line 2"), std::string::npos);
  EXPECT_NE(findings[0].text.find("line 3"), std::string::npos);
}

TEST(Kinds, EdgesWithoutInformationHaveTheIdentityAndThatIsSaidOnce) {
  const Dataset data = parsed("EDGE3 0 1 1 0 0 0 0 0\nEDGE3 1 2 1 0 0 0 0 0\n", Format::Toro);
  EXPECT_EQ(edges_of<RelativePoseEdge<Pose3>>(data)[1]->noise.written, (Matrix<6, 6>::Identity()));
  ASSERT_EQ(check(data).size(), 1u);
  EXPECT_NE(check(data)[0].text.find("2 edges have no information"), std::string::npos) << check(data)[0].text;
  EXPECT_EQ(written(data), "EDGE3 0 1 1 0 0 0 0 0\nEDGE3 1 2 1 0 0 0 0 0\n");
}

TEST(Kinds, TextOfIsam) {
  const std::string text = "ODOMETRY 0 1 1 0 0 10 0 0 10 0 20\nLANDMARK 1 0 1 2 5 0 5\nODOMETRY 1 2 1 0 0 10 1 0 10 0 20\n";
  const Dataset data = parsed(text, Format::Toro);
  const auto steps = edges_of<RelativePoseEdge<Pose2>>(data);
  Matrix<3, 3> expected;
  expected << 100, 10, 0, 10, 101, 0, 0, 0, 400;  // RᵀR
  EXPECT_LT((steps[1]->noise.written - expected).norm(), 1e-12);
  EXPECT_EQ(edges_of<RelativePointEdge<Point2>>(data)[0]->landmark, Key('l', 0));
  EXPECT_LT((vertex_start(data).at<Point2>(Key('l', 0)).value - Vector<2>(2, 2)).norm(), 1e-12);
  EXPECT_EQ(of_kind(check(data), Finding::Kind::isam_noise).size(), 1u);
  EXPECT_EQ(written(data), text);
  ReadOptions options;
  options.isam_noise = ReadOptions::IsamNoise::covariance;
  std::istringstream in("ODOMETRY 0 1 1 0 0 0.25 0 0 0.25 0 0.01\n");
  const Dataset other = parse_dataset(in, "a.txt", Format::Toro, options);
  EXPECT_NEAR(edges_of<RelativePoseEdge<Pose2>>(other)[0]->noise.written(2, 2), 100, 1e-9);
}

TEST(Kinds, BearingAndRangeOfGtsam) {
  const Dataset data = parsed("EDGE2 0 1 1 0 0 1 0 1 1 0 0\nBR 1 4 1.5707963267948966 2 0.1 0.5\n", Format::Toro);
  ASSERT_EQ(data.edges.size(), 3u);
  EXPECT_NEAR(edges_of<BearingEdge>(data)[0]->information, 100, 1e-9);
  EXPECT_EQ(edges_of<RangeEdge>(data)[0]->variance, 0.25);
  EXPECT_LT((vertex_start(data).at<Point2>(Key('l', 4)).value - Vector<2>(1, 2)).norm(), 1e-12);
  EXPECT_EQ(written(data), "EDGE2 0 1 1 0 0 1 0 1 1 0 0\nBR 1 4 1.5707963267948966 2 0.1 0.5\n");
}

TEST(Kinds, LandmarksOfBearingsAloneBeginWhereTwoMeet) {
  const Dataset data = parsed(
      "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 2 0 0\nEDGE_BEARING_SE2_XY 0 9 0.7853981633974483 1\n"
      "EDGE_BEARING_SE2_XY 1 9 2.356194490192345 1\n",
      Format::G2o);
  EXPECT_LT((vertex_start(data).at<Point2>(x(9)).value - Vector<2>(1, 1)).norm(), 1e-12);
}

TEST(Kinds, AVertexThatIsAddedStandsBeforeTheFirstEdge) {
  const std::string text = "# head\nVERTEX_SE2 0 0 0 0\nDATA 7\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n# end\n";
  const Dataset data = parsed(text, Format::G2o);
  EXPECT_EQ(to_g2o(with_values(data, vertex_start(data))),
            "# head\nVERTEX_SE2 0 0 0 0\nDATA 7\nVERTEX_SE2 1 1 0 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n# end\n");
}

TEST(Kinds, AMeasurementThatIsChangedIsNotWrittenAsItWasRead) {
  Dataset data = parsed("EDGE_SE2_SWITCHABLE 0 5 6 5 0 0 100 0 0 100 0 400\n", Format::G2o);
  std::get<RelativePoseEdge<Pose2>>(data.edges[0].measurement).measured.p[0] = 4;
  EXPECT_EQ(to_g2o(data), "EDGE_SE2 0 5 4 0 0 100 0 0 100 0 400\n");
}

TEST(Kinds, AcrossAnUnusualGapThereIsNoOdometry) {
  const std::string unit = " 1 0 0 1 0 0 1 0 1\n";
  const auto edge = [&](int i, int j) { return "EDGE_SE2 " + std::to_string(i) + " " + std::to_string(j) + unit; };
  EXPECT_EQ(odometry_edges(parsed(edge(0, 1) + edge(1, 2) + edge(2, 3) + edge(3, 100) + edge(100, 101), Format::G2o)),
            (std::vector<bool>{true, true, true, false, true}));
  EXPECT_EQ(odometry_edges(parsed(edge(0, 10) + edge(10, 20) + edge(20, 45) + edge(55, 45), Format::G2o)),
            (std::vector<bool>{true, true, true, true}));
  // Ids of landmarks are no gap.
  EXPECT_EQ(odometry_edges(parsed("VERTEX_XY 2 0 0\nVERTEX_XY 3 0 0\nVERTEX_XY 4 0 0\nVERTEX_XY 5 0 0\nVERTEX_XY 6 0 0\nVERTEX_XY 7 0 0\n" +
                                      edge(0, 1) + edge(1, 8) + edge(8, 9),
                                  Format::G2o)),
            (std::vector<bool>{true, true, true}));
}

TEST(Kinds, ConvertingSaysWhatIsLeftOut) {
  const Dataset data = parsed("VERTEX_SE2 0 0 0 0\nFIX 0\nDATA 7\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n", Format::G2o, "a.g2o");
  const Conversion pyfg = converted(data, Format::PyFG);
  std::string notes;
  for (const std::string& note : pyfg.notes) notes += note + '\n';
  for (const char* part : {"DATA", "1 vertex added", "time stamps made of the steps", "1 fixed variable written as priors"})
    EXPECT_NE(notes.find(part), std::string::npos) << notes;
  const Dataset again = parsed(to_pyfg(pyfg.dataset), Format::PyFG);
  EXPECT_EQ(again.vertices.size(), 2u);
  EXPECT_EQ(again.edges.size(), 2u);
  EXPECT_EQ(format_of_name("dir.v1/a.g2o"), Format::G2o);
  EXPECT_EQ(format_of_name("a.toro"), Format::Toro);
  EXPECT_FALSE(format_of_name("dir.g2o/a"));
}

}  // namespace
}  // namespace holdfast
