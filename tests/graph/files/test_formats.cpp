// Small files of every dialect: what is read, that writing gives it back, and what noise means.
#include <clocale>
#include <locale>
#include <random>

#include "tests/graph/files/every_line.hpp"
#include "tests/graph/files/helpers.hpp"

namespace holdfast {
namespace {

using namespace testing_io;

const std::string kCovariance6 = "0.01 0 0 0 0 -0.0 0.02 0 0 0 -0.0 0.03 0 0 -0.0 0.0005 0.0001 -0.0 0.0006 -0.0 0.0007";
const std::string kPyfg =
    "VERTEX_SE2 1248362857.700000048 A0 1.271436699 3.049075753 -1.1553912\n"
    "VERTEX_SE2 1248362857.9 A1 1e-3 -0.0 3.5\n"
    "VERTEX_SE3:QUAT 3.25 B7 1 2 3 0.0109149222867028 0.015472479659810502 0.9986462721775948 0.0484467739942002\n"
    "VERTEX_SE3:QUAT 3.5 B8 1 2 3 0 0 0.7071 0.7071\n"
    "VERTEX_XY L6 0.969290620 1.659664530\nVERTEX_XYZ M1 1 2 3\n"
    "EDGE_SE2 1.5 A0 A1 0.017 0.0005 0.0816 0.0004 -0.0 0.00001 0.0004 0 0.0001\n"
    "EDGE_RANGE 1.25 A1 L6 1.330844876 0.007306188\n"
    "EDGE_SE3:QUAT 2 B7 B8 0.1 0.2 0.3 0 0 0 1 " +
    kCovariance6 +
    "\n"
    "EDGE_SE2_XY 1.6 A0 L6 3.257094618 0.653466639 0.25 0.01 0.3\n"
    "EDGE_SE3_XYZ 1.6 B7 M1 3 2 1 0.25 0.01 0 0.3 0 0.2\n"
    "VERTEX_SE2:PRIOR 0 A0 1 2 3 1 0 0 1 0 1\n"
    "VERTEX_SE3:QUAT:PRIOR 0 B7 1 2 3 0 0 0 1 " +
    kCovariance6 +
    "\n"
    "VERTEX_XY:PRIOR 0 L6 1 2 1 0 1\nVERTEX_XYZ:PRIOR 0 M1 1 2 3 1 0 0 1 0 1\n";
const std::string kInformation6 = "10 1 0 0.5 0 0 11 0 0 0.25 0 12 0 0 0 400 1 2 401 3 402";
const std::string kG2o =
    "PARAMS_SE3OFFSET 0 0 0 0 0 0 0 1\nVERTEX_SE2 3 1 2 0.5\nVERTEX_XY 9 1 2\nVERTEX_SE3:QUAT 20 1 2 3 0 0 0.6 0.8\nVERTEX_TRACKXYZ 21 1 2 "
    "3\n"
    "FIX 3\nFIX 3\n"
    "EDGE_SE2 3 5 1 2 0.5 10 1 2 11 3 12\nEDGE_SE2_XY 5 9 0.1 0.2 10 1 11\n"
    "EDGE_SE3:QUAT 20 24 1 2 3 0 0 0.6 0.8 " +
    kInformation6 +
    "\n"
    "EDGE_SE3_TRACKXYZ 20 21 0 1 2 3 10 0 0 11 0 12\nEDGE_PRIOR_SE2 3 1 2 0.5 10 1 2 11 3 12\n"
    "EDGE_PRIOR_SE3 20 1 2 3 0 0 0 1 " +
    kInformation6 + "\nEDGE_SE3_PRIOR 20 0 1 2 3 0 0 0 1 " + kInformation6 + "\n";
const std::string kToro =
    "VERTEX2 0 1 2 0.5\nVERTEX3 10 1 2 3 0.1 -0.2 0.3\nEDGE2 0 1 1 2 0.5 10 1 11 12 2 3\n"
    "EDGE3 10 11 1 2 3 0.1 -0.2 0.3 " +
    kInformation6 + "\n";

TEST(RoundTrip, PyFG) {
  const Dataset data = parsed(kPyfg, Format::PyFG);
  EXPECT_EQ(data.vertices.size(), 6u);
  EXPECT_EQ(data.edges.size(), 9u);
  expect_same(data, parsed(to_pyfg(data), Format::PyFG));
}
TEST(RoundTrip, G2o) {
  const Dataset data = parsed(kG2o, Format::G2o);
  EXPECT_EQ(data.vertices.size(), 4u);
  EXPECT_EQ(data.edges.size(), 7u);
  EXPECT_EQ(data.fixed.size(), 2u);
  EXPECT_EQ(to_g2o(data), kG2o);
  expect_same(data, parsed(to_g2o(data), Format::G2o));
}
TEST(RoundTrip, Toro) {
  const Dataset data = parsed(kToro, Format::Toro);
  EXPECT_EQ(to_toro(data), kToro);
  expect_same(data, parsed(to_toro(data), Format::Toro));
}

TEST(Reading, ValuesAndOrder) {
  const Dataset data = parsed(kPyfg, Format::PyFG);
  EXPECT_EQ(data.vertices[0].key, Key('A', 0));
  EXPECT_EQ(*data.vertices[0].time, 1248362857.700000048);
  EXPECT_FALSE(data.vertices[4].time);
  EXPECT_EQ(data.vertices[2].line, 3u);
  EXPECT_NEAR(std::get<Pose3>(data.vertices[3].value).q.norm(), 1, 1e-15);
  const auto& range = std::get<RangeEdge>(data.edges[1].measurement);
  EXPECT_EQ(range.second, Key('L', 6));
  EXPECT_EQ(range.distance, 1.330844876);
  EXPECT_EQ(range.variance, 0.007306188);
  EXPECT_EQ(*data.edges[1].time, 1.25);
  EXPECT_TRUE(std::holds_alternative<RelativePoseEdge<Pose3>>(data.edges[2].measurement));
  EXPECT_EQ(std::get<RelativePointEdge<Point2>>(data.edges[3].measurement).noise.written(1, 0), 0.01);
  EXPECT_EQ(describe(data.edges[1]), "range A1 L6 (line 8)");
}

TEST(Reading, ToroOrderAndRollPitchYaw) {
  const Dataset data = parsed(kToro, Format::Toro);
  Matrix<3, 3> expected;
  expected << 10, 1, 2, 1, 11, 3, 2, 3, 12;
  EXPECT_EQ(std::get<RelativePoseEdge<Pose2>>(data.edges[0].measurement).noise.written, expected);
  const Pose3& pose = std::get<Pose3>(data.vertices[1].value);
  const Eigen::Matrix3d R = (Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(-0.2, Eigen::Vector3d::UnitY()) *
                             Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX()))
                                .toRotationMatrix();
  EXPECT_LT((pose.rotation() - R).norm(), 1e-15);
  Dataset changed = data;  // columns that no longer mean the value are not written
  changed.vertices[1].value = pose * pose;
  const Dataset again = parsed(to_toro(changed), Format::Toro);
  EXPECT_LT((pose * pose).local(std::get<Pose3>(again.vertices[1].value)).norm(), 1e-14);
}

TEST(Reading, ForgivesBlanksCommentsLineEnds) {
  const Dataset plain = parsed(kG2o, Format::G2o);
  std::string text = "\xEF\xBB\xBF# comment\r\n\r\n  # another\r\n";
  for (char c : kG2o) text += c == '\n' ? std::string(" \r\n\t\r\n") : c == ' ' ? std::string(" \t  ") : std::string(1, c);
  expect_same(plain, parsed(text, Format::G2o));
  EXPECT_EQ(parsed(text, Format::G2o).vertices[0].line, 6u);
  expect_same(parsed("VERTEX_SE2 1 1 2 0.5\n", Format::G2o), parsed("VERTEX_SE2 1 +1 2e0 +.5", Format::G2o));
  EXPECT_EQ(parsed("VERTEX_SE2 1 0 0 0\nFIX 1 1 7\nFIX 1\n", Format::G2o).fixed.size(), 4u);
}

TEST(Reading, UnknownTagsAreReportedAndKept) {
  const Dataset data = parsed("FOO 1 2  3\r\nVERTEX_SE2 1 0 0 0\nBAR\nFOO x\n", Format::G2o, "a.g2o");
  ASSERT_EQ(data.unknown.size(), 3u);
  EXPECT_EQ(data.unknown[0].text, "FOO 1 2  3");
  const std::vector<UnknownTag> tags = unknown_tags(data);
  ASSERT_EQ(tags.size(), 2u);
  EXPECT_EQ(tags[0].tag, "FOO");
  EXPECT_EQ(tags[0].count, 2u);
  EXPECT_EQ(tags[1].first_line, 3u);
  EXPECT_EQ(unknown_report(data), "a.g2o: 3 lines of 2 unknown tags left out: FOO (2, first in line 1), BAR (1, first in line 3)");
  EXPECT_EQ(unknown_report(parsed(kG2o, Format::G2o)), "");
  expect_same(data, parsed(to_g2o(data), Format::G2o));
  expect_message<BadFile>([&] { to_toro(data); }, {"a TORO file cannot hold line 1 'FOO 1 2  3' of a.g2o"});
}

// eᵀ I e of the format's own error, at random deviations from the measured value, equals that of what the factors take.
TEST(Noise, InformationIsThatOfTheFormatsOwnError) {
  const Dataset g2o = parsed(kG2o, Format::G2o);
  const auto& space = std::get<RelativePoseEdge<Pose3>>(g2o.edges[2].measurement);
  const auto& prior = std::get<PriorEdge<Pose2>>(g2o.edges[4].measurement);
  const Dataset toro = parsed(kToro, Format::Toro);
  const auto& first_frame = std::get<RelativePoseEdge<Pose2>>(toro.edges[0].measurement);
  const auto error2 = [](const Pose2& measured, const Pose2& x) {
    const Pose2 e = measured.inverse() * x;
    return Vector<3>(e.p[0], e.p[1], e.angle());
  };
  std::srand(7);
  for (int i = 0; i < 20; ++i) {
    const Pose3 x = space.measured.retract(1e-5 * Vector<6>::Random());
    const Pose3 error = space.measured.inverse() * x;
    Vector<6> half, full;
    half << error.p, error.q.vec() * (error.q.w() < 0 ? -1 : 1);
    full << error.p, so3::log<double>(error.q);
    EXPECT_NEAR(half.dot(space.noise.written * half) / full.dot(space.information() * full), 1, 1e-8);

    const Pose2 y = prior.measured.retract(Vector<3>::Random());
    const Vector<3> e = error2(prior.measured, y), delta = prior.measured.local(y);
    EXPECT_NEAR(e.dot(prior.noise.written * e) / delta.dot(prior.information() * delta), 1, 1e-12);

    const Pose2 z = first_frame.measured.retract(Vector<3>::Random());
    const Vector<3> e_toro = first_frame.measured.local(z), e_ours = error2(first_frame.measured, z);
    EXPECT_NEAR(e_toro.dot(first_frame.noise.written * e_toro) / e_ours.dot(first_frame.information() * e_ours), 1, 1e-12);
  }
}

TEST(Noise, G2oRotationIsHalfAngle) {
  const Dataset data = parsed("EDGE_SE3:QUAT 0 1 1 2 3 0 0 0.6 0.8 " + kInformation6 + "\n", Format::G2o);
  const auto& edge = std::get<RelativePoseEdge<Pose3>>(data.edges[0].measurement);
  const Matrix<6, 6> I = edge.information();
  EXPECT_EQ((Matrix<3, 3>(I.topLeftCorner<3, 3>())), (Matrix<3, 3>(edge.noise.written.topLeftCorner<3, 3>())));
  EXPECT_EQ((Matrix<3, 3>(I.topRightCorner<3, 3>())), (Matrix<3, 3>(edge.noise.written.topRightCorner<3, 3>() / 2)));
  EXPECT_EQ((Matrix<3, 3>(I.bottomRightCorner<3, 3>())), (Matrix<3, 3>(edge.noise.written.bottomRightCorner<3, 3>() / 4)));
}

TEST(Noise, SurvivesEveryConversion) {
  const Dataset data = parsed(kG2o, Format::G2o);
  const auto& edge = std::get<RelativePoseEdge<Pose3>>(data.edges[2].measurement);
  for (Format format : {Format::PyFG, Format::Toro, Format::G2o}) {
    const MatrixNoise<6> noise = edge.noise.converted(format, edge.measured);
    EXPECT_EQ(noise.format, format);
    EXPECT_LT((noise.information(edge.measured) - edge.information()).norm(), 1e-11 * edge.information().norm());
  }
  const auto covariance = std::get<RelativePoseEdge<Pose2>>(parsed(kPyfg, Format::PyFG).edges[0].measurement);
  EXPECT_LT((covariance.information() * covariance.noise.written - Matrix<3, 3>::Identity()).norm(), 1e-12);
}

// A robot in the plane: the height, roll and pitch of its odometry say nothing.
TEST(Noise, OfPartialInformationHasZerosAndNoCovariance) {
  const std::string line = "EDGE_SE3:QUAT 0 1 1 2 3 0 0 0 1 10 1 0 0 0 0 11 0 0 0 0 0 0 0 0 0 0 0 0 0 400\n";
  const Dataset data = parsed(line, Format::G2o);
  const auto& edge = std::get<RelativePoseEdge<Pose3>>(data.edges[0].measurement);
  EXPECT_EQ(edge.information().diagonal(), (Vector<6>() << 10, 11, 0, 0, 0, 100).finished());
  expect_same(data, parsed(to_g2o(data), Format::G2o));
  EXPECT_EQ(edge.noise.converted(Format::Toro, edge.measured).written.diagonal(), edge.information().diagonal());
  expect_message<BadNumber>([&] { edge.noise.converted(Format::PyFG, edge.measured); }, {"no inverse", "no covariance"});
}

TEST(Converting, G2oToToroAndPyFG) {
  const Dataset g2o = parsed("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 4 1 0 0.1\nEDGE_SE2 0 4 1 0 0.1 10 1 2 11 3 12\n", Format::G2o);
  const Dataset toro = parsed(to_toro(g2o), Format::Toro);
  const auto information = [](const Dataset& data) { return std::get<RelativePoseEdge<Pose2>>(data.edges[0].measurement).information(); };
  EXPECT_LT((information(toro) - information(g2o)).norm(), 1e-13);
  expect_message<BadFile>([&] { to_pyfg(g2o); }, {"a PyFG file cannot hold vertex x0 (Pose2, line 1)", "no time stamp"});
  Dataset timed = g2o;
  for (Vertex& vertex : timed.vertices) vertex.time = 1;
  for (Edge& edge : timed.edges) edge.time = 2;
  EXPECT_LT((information(parsed(to_pyfg(timed), Format::PyFG)) - information(g2o)).norm(), 1e-12);
  expect_message<BadFile>([&] { to_g2o(timed); }, {"a g2o file cannot hold vertex x0", "no time stamps"});
}

TEST(Converting, WhatDoesNotFitIsNamed) {
  const Dataset pyfg = parsed(kPyfg, Format::PyFG);
  Dataset ranges;
  ranges.edges = {pyfg.edges[1]};
  ranges.edges[0].time.reset();
  expect_message<BadFile>([&] { to_g2o(ranges); },
                          {"a g2o file cannot hold range A1 L6 (line 8)", "its ranges go from a pose in the plane to a landmark"});
  expect_message<BadFile>([&] { to_toro(ranges); }, {"a TORO file cannot hold range A1 L6"});
  Dataset named;
  named.vertices = {pyfg.vertices[0]};
  named.vertices[0].time.reset();
  named.vertices[0].key = Key::from_bits(5);  // 5 is x5's id
  expect_message<BadFile>([&] { to_g2o(named); }, {"a g2o file cannot hold vertex 0x0000000000000005", "no integer id", "x5"});
  named.vertices = {pyfg.vertices[5]};
  expect_message<BadFile>([&] { to_toro(named); }, {"vertex M1 (Point3, line 6)", "poses alone"});
  expect_message<BadFile>([&] { to_pyfg(parsed("VERTEX_XY 1 0 0\nFIX 1\n", Format::G2o)); }, {"PyFG", "fixed variable x1"});
  Dataset broken = parsed(kG2o, Format::G2o);
  std::get<Pose2>(broken.vertices[0].value).p[0] = std::nan("");
  expect_message<BadFile>([&] { to_g2o(broken); }, {"cannot write 'VERTEX_SE2 3 nan'", "not finite"});
}

Dataset only(const VertexValue& value, std::optional<double> time) {
  Dataset dataset;
  dataset.vertices.push_back({Key('x', 1), value, {}, time, 0});
  return dataset;
}
Dataset only(const Measurement& measurement, std::optional<double> time) {
  Dataset dataset;
  dataset.edges.push_back({measurement, time, 0});
  return dataset;
}

TEST(Converting, WhatAFormatHasNoLineForIsNamed) {
  const Key x1('x', 1), x2('x', 2);
  const RangeEdge range{x1, x2, 3, 1};
  const RelativePoseEdge<Pose2> pose{x1, x2, Pose2(1, 0, 0), {}, {}};
  const RelativePointEdge<Point2> point{x1, x2, Point2(1, 0), {}, {}, 0};
  const PriorEdge<Pose2> prior{x1, Pose2(), {}, {}, {}};
  const PriorEdge<Point2> point_prior{x1, Point2(), {}, {}, {}};
  Dataset fixed, offset;
  fixed.fixed.push_back({x1, 0});
  offset.offsets.push_back({7, Pose3(), {}, 0});
  const std::optional<double> no_time, time = 2;
  const struct {
    Dataset dataset;
    Format format;
    std::vector<std::string> parts;
  } all[] = {
      {only(Pose2(), no_time), Format::PyFG, {"a PyFG file cannot hold vertex x1 (Pose2)", "no time stamp; give it one"}},
      {only(Point2(), time), Format::PyFG, {"vertex x1 (Point2)", "point vertices have no time stamp; clear it"}},
      {only(range, no_time), Format::PyFG, {"range x1 x2", "no time stamp; give it one"}},
      {fixed, Format::PyFG, {"the fixed variable x1", "no FIX line; clear `fixed`, or add a prior"}},
      {only(Point3(), time), Format::G2o, {"a g2o file cannot hold vertex x1 (Point3)", "no time stamps; clear them"}},
      {only(pose, time), Format::G2o, {"relative pose x1 x2", "no time stamps; clear them"}},
      {only(range, no_time), Format::G2o, {"range x1 x2", "its ranges go from a pose in the plane to a landmark", "write PyFG"}},
      {only(point, no_time), Format::G2o, {"relative point x1 x2", "name no sensor offset; clear it"}},
      {only(point_prior, no_time), Format::Toro, {"prior x1", "relative poses alone"}},
      {only(BearingEdge{x1, x2, 0.5, 1}, time), Format::PyFG, {"bearing x1 x2", "no bearing"}},
      {only(PositionEdge<Point2>{x1, Point2(), {}, {}}, time), Format::PyFG, {"position prior x1", "no prior on a position alone"}},
      {only(Pose2(), time), Format::Toro, {"a TORO file cannot hold vertex x1 (Pose2)", "no time stamps; clear them"}},
      {only(Point2(), no_time), Format::Toro, {"vertex x1 (Point2)", "poses alone"}},
      {only(pose, time), Format::Toro, {"relative pose x1 x2", "no time stamps; clear them"}},
      {only(prior, no_time), Format::Toro, {"prior x1", "relative poses alone"}},
      {fixed, Format::Toro, {"the fixed variable x1", "no FIX line"}},
      {offset, Format::Toro, {"a sensor offset", "no PARAMS lines"}},
  };
  for (const auto& one : all) {
    SCOPED_TRACE(one.parts.back());
    expect_message<BadFile>([&] { to_text(one.dataset, one.format); }, one.parts);
  }
}

TEST(Converting, ASensorOffsetIsTheIdentityAndLeftOutOfPyFG) {
  Dataset dataset = only(RelativePointEdge<Point3>{Key('x', 1), Key('L', 2), Point3(1, 2, 3), {}, {}, 7}, 0.5);
  dataset.offsets.push_back({7, Pose3(), {}, 0});
  EXPECT_EQ(to_pyfg(dataset), "EDGE_SE3_XYZ 0.5 x1 L2 1 2 3 1 0 0 1 0 1\n");
}

TEST(Converting, ALandmarkInSpaceNamesTheIdentity) {
  const Dataset dataset = only(RelativePointEdge<Point3>{Key('x', 1), Key('x', 2), Point3(1, 2, 3), {}, {}}, std::nullopt);
  EXPECT_EQ(to_g2o(dataset), "PARAMS_SE3OFFSET 0 0 0 0 0 0 0 1\nEDGE_SE3_TRACKXYZ 1 2 0 1 2 3 1 0 0 1 0 1\n");
}

// A landmark at a sensor 0.1 m ahead of the body that looks to the left: (2, 0) there is (0.1, 2) in the body.
TEST(SensorOffsets, LandmarksAndPosesAreInTheBodysFrame) {
  const std::string text =
      "PARAMS_SE2OFFSET 4 0.1 0 1.5707963267948966\nEDGE_SE2_POINTXY_OFFSET 0 7 4 2 0 9 0 1\n"
      "EDGE_SE2_OFFSET 0 1 4 4 0 -1 0 9 0 0 1 0 4\n";
  const Dataset data = parsed(text, Format::G2o);
  const auto& point = std::get<RelativePointEdge<Point2>>(data.edges[0].measurement);
  EXPECT_LT((point.measured.value - Vector<2>(0.1, 2)).norm(), 1e-15);
  EXPECT_NEAR(point.information()(0, 0), 1, 1e-14);  // along the body's x the sensor's y
  EXPECT_NEAR(point.information()(1, 1), 9, 1e-14);
  const auto& step = std::get<RelativePoseEdge<Pose2>>(data.edges[1].measurement);
  EXPECT_LT((step.measured.p - Vector<2>(1, 0)).norm(), 1e-15);  // the sensor's −y is the body's x
  EXPECT_EQ(to_g2o(data), text);
  // The information of the body's deviation is that of the sensor's, to first order.
  const Pose2 sensor(0.1, 0, kPi / 2), read(0, -1, 0);
  Matrix<3, 3> at_sensor = Vector<3>(9, 1, 4).asDiagonal();
  for (const Vector<3>& delta : {Vector<3>(1e-4, 0, 0), Vector<3>(0, 1e-4, 0), Vector<3>(0, 0, 1e-4), Vector<3>(1e-4, -2e-4, 1e-4)}) {
    const Pose2 body = step.measured * Pose2(delta[0], delta[1], delta[2]);
    const Pose2 deviation = read.inverse() * (sensor.inverse() * body * sensor);
    const Vector<3> e(deviation.p[0], deviation.p[1], deviation.angle());
    EXPECT_NEAR(e.dot(at_sensor * e) / delta.dot(step.information() * delta), 1, 1e-3);
  }
}

// What hdl_graph_slam's own error is about a small turn.
TEST(Noise, OfARotationPriorIsThatOfItsQuaternion) {
  const Dataset data = parsed("EDGE_SE3_PRIORQUAT 3 0.8 0.6 0 0 10 1 2 20 3 30\n", Format::G2o);
  const auto& prior = std::get<PriorEdge<Pose3>>(data.edges[0].measurement);
  Matrix<3, 3> I;
  I << 10, 1, 2, 1, 20, 3, 2, 3, 30;
  for (const Vector<3>& phi : {Vector<3>(1e-4, 0, 0), Vector<3>(0, 1e-4, 0), Vector<3>(1e-4, -1e-4, 2e-4)}) {
    Vector<6> delta = Vector<6>::Zero();
    delta.tail<3>() = phi;
    const Pose3 x = prior.measured.retract(delta);
    const Vector<3> e = x.q.vec() - prior.measured.q.vec();
    EXPECT_NEAR(e.dot(I * e) / delta.dot(prior.information() * delta), 1, 1e-3);
  }
}

struct German : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

TEST(Locale, ChangesNothing) {
  const std::string far = std::string(1499, '\n') + "VERTEX_SE2 1 2 3 oops\n";
  const Dataset expected = parsed(kPyfg, Format::PyFG);
  const std::string text = to_pyfg(expected);
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new German));
  const std::string c_before = std::setlocale(LC_ALL, nullptr);
  std::setlocale(LC_ALL, "de_DE.UTF-8");  // where it is installed
  const Dataset read = parsed(kPyfg, Format::PyFG);
  const std::string again = to_pyfg(read);
  expect_message<BadFile>([&] { parsed(far, Format::G2o); }, {"line 1500", "'oops'"});
  std::setlocale(LC_ALL, c_before.c_str());
  std::locale::global(before);
  expect_same(expected, read);
  EXPECT_EQ(text, again);
}
// ---- random edits of valid files: refused by name, or every line is read, kept or named

/// Lines of every kind that the formats have.
std::vector<std::string> valid_files() {
  const std::string one21 = " 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1";
  return {
      "# comment\nPARAMS_SE2OFFSET 3 0.1 0 0.5\nVERTEX_SE2 0 0 0 0\nROBOTLASER1 0 1 2\nVERTEX_SE2 1 1 0 0\nVERTEX_XY 7 1 1\n\nFIX 0 1\n"
      "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 1 2 1 0 0\nEDGE_SE2_XY 0 7 1 1 1 0 1\nEDGE_BEARING_SE2_XY 0 7 0.7 10\n"
      "EDGE_RANGE_SE2_XY 1 7 1 10\nEDGE_PRIOR_SE2_XY 1 1 0 1 0 1\nEDGE_PRIOR_XY 7 1 1 1 0 1\nEDGE_SE2_OFFSET 0 1 3 3 1 0 0 1 0 0 1 0 1\n"
      "EDGE_SE2_POINTXY_OFFSET 0 7 3 1 1 1 0 1\nVERTEX_SWITCH 9 1\nEDGE_SE2_SWITCHABLE 0 2 9 2 0 0 1 0 0 1 0 1\n"
      "EDGE_SE2_MAXMIX 0 2 0.1 2 0 0 1 0 0 1 0 1\nEDGE_SE2_XY_PRIOR 0 0 0 0 0 0\n",
      "PARAMS_SE3OFFSET 0 0.2 0 0 0 0 0 1\nVERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 1 0 0 0 0 0 1\nVERTEX_TRACKXYZ 0 1 1 1\n"
      "EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1" +
          one21 + "\nEDGE_SE3_TRACKXYZ 0 0 0 1 1 1 1 0 0 1 0 1\nEDGE_SE3_PRIOR 0 0 0 0 0 0 0 0 1" + one21 +
          "\nEDGE_SE3_PRIORXYZ 1 1 0 0 1 0 0 1 0 1\nEDGE_SE3_PRIORXY 1 1 0 1 0 1\nEDGE_SE3_PRIORQUAT 1 1 0 0 0 1 0 0 1 0 1\n"
          "EDGE_SE3_XYZ_PRIOR 1 0 1 0 0 1 0 0 1 0 1\nEDGE_SE3_OFFSET 0 1 0 0 1 0 0 0 0 0 1" +
          one21 + "\nEDGE_POINTXYZ_PRIOR 0 1 1 1 1 0 0 1 0 1\n",
      "VERTEX2 0 0 0 0\nVERTEX2 1 1 0 0\nEDGE2 0 1 1 0 0 1 0 1 1 0 0\nEDGE2 1 2 1 0 0\nODOMETRY 2 3 1 0 0 10 0 0 10 0 10\n"
      "LANDMARK 3 0 1 1 10 0 10\nBR 3 1 0.5 2 0.1 0.1\nEQUIV 0 3\n# end\n",
      kPyfg};
}

TEST(EveryLine, IsReadKeptOrNamed) {
  std::mt19937_64 rng(20);
  const std::vector<std::string> files = valid_files();
  for (const std::string& file : files) {
    std::istringstream in(file);
    EXPECT_EQ(missing_line(parse_dataset(in, "valid"), file), "");
  }
  int accepted = 0;
  for (int run = 0; run < 20000; ++run) {
    std::string text = files[rng() % files.size()];
    for (std::uint64_t edits = 1 + rng() % 3; edits > 0 && !text.empty(); --edits) {
      const std::size_t at = rng() % text.size();
      const std::size_t begin = text.rfind('\n', at) == std::string::npos ? 0 : text.rfind('\n', at) + 1;
      const std::size_t end = std::min(text.find('\n', at), text.size() - 1) + 1;
      switch (rng() % 6) {
        case 0:
          text[at] = static_cast<char>(rng());
          break;
        case 1:  // a line twice
          text.insert(begin, text.substr(begin, end - begin));
          break;
        case 2:  // a line gone
          text.erase(begin, end - begin);
          break;
        case 3:  // a line behind all others
          text += text.substr(begin, end - begin);
          break;
        case 4:  // another digit
          if (text[at] >= '0' && text[at] <= '9') text[at] = static_cast<char>('0' + rng() % 10);
          break;
        default:
          text.insert(at, std::string(1, "\n # -"[rng() % 5]));
      }
    }
    if (text.empty()) continue;
    try {
      ReadOptions options;
      options.repair = rng() % 2 == 0;
      std::istringstream in(text);
      const Dataset data = parse_dataset(in, "edited", options);
      ++accepted;
      ASSERT_EQ(missing_line(data, text), "") << text;
      const std::string again = to_text(data, data.format);
      std::istringstream second(again);
      const Dataset reread = parse_dataset(second, "again", data.format, options);
      ASSERT_EQ(missing_line(reread, again), "") << again;
      ASSERT_EQ(reread.edges.size(), data.edges.size()) << text;
      ASSERT_EQ(to_text(reread, data.format), again) << text;
    } catch (const BadFile& error) {  // names the line or the file
      ASSERT_FALSE(std::string(error.what()).empty());
    }
  }
  EXPECT_GT(accepted, 2000);
}

}  // namespace
}  // namespace holdfast
