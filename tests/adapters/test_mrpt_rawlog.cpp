// Ranges and bearings of MRPT's .rawlog files, and beacons that only ranges know.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationBearingRange.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CRawlog.h>
#include <mrpt/poses/CPosePDFGaussian.h>

#include <filesystem>
#include <fstream>
#include <holdfast/adapters/files/problem.hpp>
#include <holdfast/adapters/files/range_start.hpp>
#include <holdfast/adapters/mrpt/rawlog.hpp>
#include <holdfast/graph/error.hpp>
#include <holdfast/solvers/table.hpp>
#include <iostream>

namespace holdfast::testing {
namespace {

using namespace mrpt::obs;
using ::testing::HasSubstr;

std::string temporary(const char* name) { return (std::filesystem::path(::testing::TempDir()) / name).string(); }

template <class Fn>
std::string message_of(const Fn& fn) {
  try {
    fn();
  } catch (const BadFile& error) {
    return error.what();
  }
  return "";
}

CActionRobotMovement2D step(double x, double y, double phi) {
  CActionRobotMovement2D action;
  mrpt::poses::CPosePDFGaussian change;
  change.mean = mrpt::poses::CPose2D(x, y, phi);
  change.cov.setDiagonal(std::vector<double>{0.04, 0.01, 0.0025});
  action.estimationMethod =
      CActionRobotMovement2D::emScan2DMatching;  // of odometry MRPT keeps the raw increment and a motion model instead
  action.poseChange = mrpt::poses::CPosePDF::Ptr(new mrpt::poses::CPosePDFGaussian(change));
  return action;
}

void save(const std::vector<CSensoryFrame>& frames, const std::string& path) {
  CRawlog log;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    CSensoryFrame frame = frames[k];
    log.insert(frame);
    CActionCollection actions;
    auto action = step(1, 0.5, 0.3);
    actions.insert(action);
    if (k + 1 < frames.size()) log.insert(actions);
  }
  ASSERT_TRUE(log.saveToRawLogFile(path));
}

CSensoryFrame frame_of(const CObservation::Ptr& observation) {
  CSensoryFrame frame;
  frame.insert(observation);
  return frame;
}

CObservationBeaconRanges::Ptr ranges(double receiver_x = 0) {
  auto observation = CObservationBeaconRanges::Create();
  observation->stdError = 0.5f;
  observation->minSensorDistance = 0.25f;
  observation->maxSensorDistance = 10;
  for (const auto& [id, distance] : {std::pair(4, 2.5f), std::pair(5, 10.5f), std::pair(INVALID_BEACON_ID, 1.0f)}) {
    CObservationBeaconRanges::TMeasurement one;
    one.beaconID = id;
    one.sensedDistance = distance;
    one.sensorLocationOnRobot = mrpt::poses::CPoint3D(receiver_x, 0, 0);
    observation->sensedData.push_back(one);
  }
  return observation;
}

TEST(MrptRawlog, OdometryAndRangesAsTheyWereWritten) {
  const std::string path = temporary("ranges.rawlog");
  save({frame_of(ranges()), frame_of(ranges())}, path);
  const Dataset dataset = read_rawlog(path);
  ASSERT_EQ(dataset.edges.size(), 3u);
  const auto& range = std::get<RangeEdge>(dataset.edges[0].measurement);
  EXPECT_EQ(range.first, Key('x', 0));
  EXPECT_EQ(range.second, Key('b', 4));
  EXPECT_EQ(range.distance, 2.5);
  EXPECT_EQ(range.variance, 0.25);
  const auto& odometry = std::get<RelativePoseEdge<Pose2>>(dataset.edges[1].measurement);
  EXPECT_EQ(odometry.second, Key('x', 1));
  EXPECT_LT(Pose2(1, 0.5, 0.3).local(odometry.measured).norm(), 1e-15);
  // (x y φ) are the parent's: at a turn of 0.3 rad the information of the deviation is turned by it
  const Matrix<2, 2> R = Pose2(0, 0, 0.3).rotation();
  const Matrix<2, 2> expected = R.transpose() * Vector<2>(25, 100).asDiagonal() * R;
  EXPECT_LT((odometry.information().topLeftCorner<2, 2>() - expected).norm(), 1e-9);
  EXPECT_NEAR(odometry.information()(2, 2), 400, 1e-9);
  EXPECT_THAT(unknown_report(dataset), HasSubstr("without an id (2"));
  EXPECT_THAT(unknown_report(dataset), HasSubstr("out of the sensor's limits (2"));
}

TEST(MrptRawlog, BearingsBecomePointsInTheRobotsFrame) {
  auto observation = CObservationBearingRange::Create();
  observation->sensor_std_range = 0.1f;
  observation->sensor_std_yaw = 0.02f;
  observation->sensorLocationOnRobot = mrpt::poses::CPose3D(0.5, 0, 0, kPi / 2, 0, 0);
  CObservationBearingRange::TMeasurement one;
  one.landmarkID = 9;
  one.range = 2;
  one.yaw = one.pitch = 0;
  observation->sensedData.push_back(one);
  const std::string path = temporary("bearings.rawlog");
  save({frame_of(observation), frame_of(observation)}, path);
  const Dataset dataset = read_rawlog(path);
  const auto& point = std::get<RelativePointEdge<Point2>>(dataset.edges[0].measurement);
  EXPECT_EQ(point.landmark, Key('l', 9));
  EXPECT_LT((point.measured.value - Vector<2>(0.5, 2)).norm(), 1e-12);  // ahead of a sensor that looks to the left
  const Matrix<2, 2> I = point.information();
  EXPECT_NEAR(I(1, 1), 100, 1e-4);                // along the ray: 0.1 m
  EXPECT_NEAR(I(0, 0), 1 / (0.04 * 0.04), 1e-2);  // across: 2 m · 0.02
  EXPECT_NEAR(I(0, 1), 0, 1e-6);
}

TEST(MrptRawlog, WhatItCannotHoldIsNamed) {
  const std::string path = temporary("lever.rawlog");
  save({frame_of(ranges(0.3)), frame_of(ranges(0.3))}, path);
  EXPECT_THAT(message_of([&] { read_rawlog(path); }), HasSubstr("beacon 4"));
  const std::string text = temporary("text.rawlog");
  std::ofstream(text) << "VERTEX2 0 0 0 0\n";
  EXPECT_THAT(message_of([&] { read_rawlog(text); }), HasSubstr(text));
  EXPECT_THAT(message_of([] { read_rawlog("/nowhere.rawlog"); }), HasSubstr("/nowhere.rawlog"));
}

TEST(MrptRawlog, BeaconsOfRoSlamDemoAreFoundWithoutAGuess) {
  const std::string path = "/usr/share/mrpt/datasets/RO-SLAM_demo.rawlog";
  if (!std::filesystem::is_regular_file(path)) GTEST_SKIP() << "mrpt-common is not installed: there is no " << path;
  Problem problem = make_problem(located_by_ranges(read_rawlog(path)), {Huber{2}});
  ASSERT_TRUE(make_backend("irls")->solve(problem.graph, problem.start).usable());
  std::ifstream truth("/usr/share/mrpt/datasets/RO-SLAM_demo_ground_truth.txt");
  double sum = 0;
  int count = 0;
  for (std::string line; std::getline(truth, line); ++count) {
    std::istringstream columns(line);
    int id;
    double x, y;
    columns >> id >> x >> y;
    sum += (problem.start.at<Point2>(Key('b', id)).value - Vector<2>(x, y)).squaredNorm();
  }
  ASSERT_EQ(count, 15);
  std::cout << "RO-SLAM_demo: rmse of 15 beacons " << std::sqrt(sum / count) << " m (ranges: sigma 0.01 m)\n";
  EXPECT_LT(std::sqrt(sum / count), 0.01);
}

}  // namespace
}  // namespace holdfast::testing
