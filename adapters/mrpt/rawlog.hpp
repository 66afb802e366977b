// MRPT's .rawlog: odometry, ranges to beacons, ranges with bearings to landmarks.
//
//   Problem problem = make_problem(located_by_ranges(read_rawlog("RO-SLAM_demo.rawlog")), {Huber{2}});
//
// Pose x<k> is the robot's after its k-th action; beacons are b<id>, landmarks l<id>. Actions in the plane (CActionRobotMovement2D) make
// Pose2, in space (CActionRobotMovement3D) Pose3; both in one file are an error, and without any action there is one pose in the plane.
//   CObservationBeaconRanges   a RangeEdge a beacon, sigma = stdError; a range outside (minSensorDistance, maxSensorDistance] is dropped by
//                              the sensor's own rule
//   CObservationBearingRange   a RelativePointEdge a landmark: the point in the robot's frame, its covariance by the Jacobian of the polar
//                              coordinates (so bearings of a few degrees at most)
// The mean and covariance of an action are the odometry. Whatever else the file holds is counted in Dataset::unknown by class, and so are
// observations without an id. BadFile where the file cannot be read, or a beacon's receiver sits off the robot's origin (Range has no
// lever).
#pragma once

#include <holdfast/graph/files/dataset.hpp>

namespace holdfast {

Dataset read_rawlog(const std::string& path);

}  // namespace holdfast
