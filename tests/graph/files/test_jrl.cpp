// JRL: what is read, that writing gives it back, and that what is wrong is named with its line.
#include <holdfast/graph/files/jrl.hpp>

#include "tests/graph/files/every_line.hpp"
#include "tests/graph/files/helpers.hpp"

namespace holdfast {
namespace {

using namespace testing_io;

constexpr Agent a('a'), b('b'), L('L');
std::string bits(Key key) { return std::to_string(key.bits()); }

/// The identity of 6 with numbers on its diagonal: rotation first, as GTSAM has it.
std::string covariance6(double rotation, double translation) {
  std::string text = "[";
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) text += (i + j > 0 ? ", " : "") + std::to_string(i != j ? 0.0 : i < 3 ? rotation : translation);
  return text + "]";
}
std::string pose3(double x) {
  return R"({"type": "Pose3", "translation": [)" + std::to_string(x) + R"(, 2, 3], "rotation": [0.8, 0, 0, 0.6]})";
}

std::string two_robots() {
  return R"({"name": "two \"robots\"", "robots": [97, 98],
"measurements": {
 "a": [{"stamp": 0, "measurements": [
   {"type": "PriorFactorPose3", "key": )" +
         bits(a(0)) + R"(, "prior": )" + pose3(1) + R"(, "covariance": )" + covariance6(0.25, 4) + R"(}]},
  {"stamp": 1, "measurements": [
   {"type": "BetweenFactorPose3", "key1": )" +
         bits(a(0)) + R"(, "key2": )" + bits(a(1)) + R"(, "measurement": )" + pose3(2) + R"(, "covariance": )" + covariance6(0.25, 4) +
         R"(},
   {"type": "RangeFactorPose3", "key1": )" +
         bits(a(1)) + R"(, "key2": )" + bits(b(0)) + R"(, "measurement": 5.5, "covariance": [0.01]}]}],
 "b": [{"stamp": 1, "measurements": [
   {"type": "RangeFactor3D", "key1": )" +
         bits(b(0)) + R"(, "key2": )" + bits(L(4)) + R"(, "measurement": 1.5, "covariance": [0.04]}]}]},
"groundtruth": {"a": []},
"initialization": {
 "a": [{"key": )" +
         bits(a(0)) + ", " + pose3(1).substr(1) + R"(, {"key": )" + bits(a(1)) + ", " + pose3(3).substr(1) + R"(],
 "b": [{"key": )" +
         bits(b(0)) + ", " + pose3(4).substr(1) + R"(, {"key": )" + bits(L(4)) + R"(, "type": "Point3", "x": 1, "y": 2, "z": 3}]},
"outlier_factors": {"a": [[1, 1]]}})";
}

// A loop closure or a whole file in one entry says nothing of when its older states were: no two states of an agent at one time.
TEST(Jrl, AStampIsTheTimeOfOneState) {
  const auto step = [](int from, int to) {
    return R"({"type": "BetweenFactorPose3", "key1": )" + bits(a(from)) + R"(, "key2": )" + bits(a(to)) + R"(, "measurement": )" +
           pose3(2) + R"(, "covariance": )" + covariance6(0.25, 4) + "}";
  };
  const auto file = [&](const std::string& entries) {
    std::string values;
    for (int k = 0; k < 3; ++k) values += (k == 0 ? "" : ", ") + (R"({"key": )" + bits(a(k)) + ", " + pose3(k).substr(1));
    return R"({"name": "one", "robots": [97], "measurements": {"a": [)" + entries + R"(]}, "initialization": {"a": [)" + values + "]}}";
  };
  const auto entry = [](int stamp, const std::string& list) {
    return R"({"stamp": )" + std::to_string(stamp) + R"(, "measurements": [)" + list + "]}";
  };
  const Dataset apart = parse_jrl(file(entry(5, step(0, 1)) + ", " + entry(7, step(2, 1) + ", " + step(0, 2))), "a.jrl");
  EXPECT_FALSE(apart.vertices[0].time.has_value());
  EXPECT_EQ(apart.vertices[1].time, 5.0);
  EXPECT_EQ(apart.vertices[2].time, 7.0);
  for (const Vertex& vertex : parse_jrl(file(entry(5, step(0, 1) + ", " + step(1, 2))), "b.jrl").vertices)
    EXPECT_FALSE(vertex.time.has_value());
}

TEST(Jrl, IsReadByItsContent) {
  std::istringstream in(two_robots());
  const Dataset data = parse_dataset(in, "two.jrl");
  ASSERT_EQ(data.vertices.size(), 4u);
  EXPECT_EQ(data.vertices[1].key, a(1));
  EXPECT_EQ(data.vertices[1].time, 1.0);
  EXPECT_EQ(std::get<Point3>(data.vertices[3].value).value, Vector<3>(1, 2, 3));
  ASSERT_EQ(data.edges.size(), 4u);
  const auto& step = std::get<RelativePoseEdge<Pose3>>(data.edges[1].measurement);
  EXPECT_EQ(step.measured.p, Vector<3>(2, 2, 3));
  EXPECT_NEAR(step.measured.q.z(), 0.6, 1e-15);
  // 4 m² of translation and 0.25 rad² of rotation, though rotation stands first in the file.
  const Matrix<6, 6> I = step.information();
  EXPECT_NEAR(I(0, 0), 0.25, 1e-15);
  EXPECT_NEAR(I(5, 5), 4, 1e-14);
  const auto& range = std::get<RangeEdge>(data.edges[2].measurement);
  EXPECT_EQ(range.distance, 5.5);
  EXPECT_EQ(range.variance, 0.01);
  ASSERT_EQ(data.unknown.size(), 2u);  // truth beside an initialization, a list of outliers
  EXPECT_EQ(data.unknown[0].tag, "groundtruth");
}

TEST(Jrl, ComesBack) {
  const Dataset data = parse_jrl(two_robots(), "two.jrl");
  const std::string text = to_jrl(data);
  const Dataset again = parse_jrl(text, "two.jrl");
  expect_same(data, again);
  EXPECT_EQ(to_jrl(again), text);
  EXPECT_NE(text.find(R"("outlier_factors": {"a": [[1, 1]]})"), std::string::npos);
}

TEST(Jrl, ABearingWithItsRangeIsTwoMeasurements) {
  const std::string text = R"({"measurements": {"a": [{"stamp": 2, "measurements": [
{"type": "BearingRangeFactor2D", "key1": )" +
                           bits(a(0)) + R"(, "key2": )" + bits(L(1)) +
                           R"(, "measurement": {"bearing": 0.5, "range": 3}, "covariance": [0.01, 0, 0, 0.25]}]}]},
"groundtruth": {"a": [{"key": )" +
                           bits(a(0)) + R"(, "type": "Pose2", "x": 1, "y": 2, "theta": 0.5}, {"key": )" + bits(L(1)) +
                           R"(, "type": "Point2", "x": 1, "y": 2}]}})";
  const Dataset data = parse_jrl(text, "a.jrl");
  ASSERT_EQ(data.edges.size(), 2u);
  EXPECT_NEAR(std::get<BearingEdge>(data.edges[0].measurement).information, 100, 1e-12);
  EXPECT_EQ(std::get<RangeEdge>(data.edges[1].measurement).variance, 0.25);
  EXPECT_EQ(data.vertices.size(), 2u);
  const Dataset again = parse_jrl(to_jrl(data), "a.jrl");
  EXPECT_EQ(again.edges.size(), 2u);
  EXPECT_NE(to_jrl(data).find("BearingRangeFactor2D"), std::string::npos);
}

TEST(Jrl, TruthStandsBesideAnInitialization) {
  EXPECT_TRUE(parse_jrl_truth(two_robots(), "two.jrl").empty());
  const std::string text = R"({"measurements": {}, "initialization": {"a": [{"key": 1, "type": "Point2", "x": 1, "y": 2}]},
"groundtruth": {"a": [{"key": 1, "type": "Point2", "x": 3, "y": 4}]}})";
  EXPECT_EQ(std::get<Point2>(parse_jrl(text, "a.jrl").vertices[0].value).value, Vector<2>(1, 2));
  ASSERT_EQ(parse_jrl_truth(text, "a.jrl").size(), 1u);
  EXPECT_EQ(std::get<Point2>(parse_jrl_truth(text, "a.jrl")[0].value).value, Vector<2>(3, 4));
}

TEST(Jrl, OtherMeasurementsAreKeptByName) {
  const std::string text =
      R"({"measurements": {"a": [{"stamp": 2, "measurements": [{"type": "MyFactor", "key": 3}]}]}, "groundtruth": {"a": [{"key": 1,
"type": "Pose2", "x": 1, "y": 2, "theta": 0.5}]}})";
  const Dataset data = parse_jrl(text, "a.jrl");
  ASSERT_EQ(data.unknown.size(), 1u);
  EXPECT_EQ(data.unknown[0].tag, "MyFactor");
  expect_message<BadFile>([&] { to_jrl(data); }, {"MyFactor"});
}

TEST(Jrl, WhatIsWrongIsNamedWithItsLine) {
  const std::string good = two_robots();
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  expect_message<BadFile>([&] { parse_jrl(with("\"covariance\": [0.01]", "\"covariance\": [0.01, 1]"), "x.jrl"); },
                          {"x.jrl, line 7", "expected a list of 1 numbers"});
  expect_message<BadFile>([&] { parse_jrl(with("5.5", "-5.5"), "x.jrl"); }, {"line 7", "expected a range >= 0"});
  expect_message<BadFile>([&] { parse_jrl(with("\"stamp\": 0", "\"stamp\": -1"), "x.jrl"); }, {"line 3", "an integer from 0"});
  expect_message<BadFile>([&] { parse_jrl(with("[0.8, 0, 0, 0.6]", "[0.8, 0, 0, 0.7]"), "x.jrl"); }, {"line 4", "has norm"});
  expect_message<BadFile>([&] { parse_jrl(good.substr(0, good.size() / 2), "x.jrl"); }, {"x.jrl, line", "is the file cut?"});
  expect_message<BadFile>([&] { parse_jrl("{\"a\": 1}", "x.jrl"); }, {"measurements"});
  expect_message<BadFile>([&] { parse_jrl(std::string(1000, '['), "x.jrl"); }, {"more than 100 deep"});
}

}  // namespace
}  // namespace holdfast
