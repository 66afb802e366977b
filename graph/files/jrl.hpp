// JRL (.jrl): the JSON of COSMO-Bench and riMESA, measurements, values and truth of several robots under GTSAM's keys.
// Format: https://github.com/DanMcGann/jrl (format/*.md).
//
//   Dataset data = read_dataset("a.jrl");              // by its content, as any other file
//   write_jrl("b.jrl", data);
//
// A dataset that was read from JRL is one of Format::PyFG: covariances, time stamps, names. Its vertices are the `initialization`, else the
// `groundtruth`. GTSAM's covariances of Pose3 are in the order rotation, translation, and are of the full angle: only the order changes.
//   PriorFactorX, BetweenFactorX          X = Pose2, Pose3, Point2, Point3
//   RangeFactorX                          X = Pose2, Pose3, 2D, 3D
//   BearingRangeFactor2D                  with a diagonal covariance: a bearing and a range
// Whatever else there is is in Dataset::unknown, its text in JSON. Truth beside an initialization and lists of outliers are written back
// into a JRL file (lists only while every measurement is where it stood); other factors and values are not, and none into another format.
// Stamps from 1e17 on are nanoseconds, others are taken as they are. A stamp is the time of the state that measures (of odometry, the
// newer one); of none where several states of an agent share it.
#pragma once

#include <holdfast/graph/files/dataset.hpp>
#include <string_view>

namespace holdfast {

/// BadFile names the file, the line, what was found and what was expected.
Dataset parse_jrl(std::string_view text, const std::string& name);

/// Its `groundtruth`, empty where it has none.
std::vector<Vertex> parse_jrl_truth(std::string_view text, const std::string& name);

/// Measurements by robot (the kind of their first key) and time stamp; the values are the `initialization`. BadFile where a measurement
/// has no covariance (a semidefinite information), or is a step or bearing that JRL has no factor for; a fixed variable.
std::string to_jrl(const Dataset& dataset);
void write_jrl(const std::string& path, const Dataset& dataset);

/// Is this line of Dataset::unknown a piece of a JRL file?
bool is_of_jrl(const UnknownLine& line);

}  // namespace holdfast
