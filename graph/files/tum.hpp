// Trajectories in the TUM format, which `evo` reads: `t x y z qx qy qz qw`, one file per agent. Written, never read.
#pragma once

#include <holdfast/graph/files/dataset.hpp>
#include <holdfast/graph/values.hpp>
#include <string>
#include <unordered_map>
#include <vector>

namespace holdfast {

struct StampedValue {
  double time;  ///< [s]
  VertexValue value;
};

/// One trajectory, in the order given. In the plane z = 0 and the rotation is about z; a point has the identity rotation.
/// Written whole or not at all; BadFile where a number is not finite or the file cannot be written.
std::string to_tum(const std::vector<StampedValue>& trajectory);
void write_tum(const std::string& path, const std::vector<StampedValue>& trajectory);

/// The time stamps of the vertices that have one [s].
std::unordered_map<Key, double> vertex_times(const Dataset& dataset);

/// The poses (Pose2, Pose3) of each agent into directory/A.tum, directory/r1234.tum, …, sorted by time, then step, the times
/// strictly increasing: of two poses at one time the later step gets the next double. The directory is made where it is missing. An
/// agent none of whose poses has a time stamp is written with its STEPS as times; one with stamps for some poses only is a BadFile
/// naming the first pose without. Agents whose kind is no letter go to agent_<code>.tum or agent_<code>_<number>.tum. Returns the
/// paths written, by agent.
std::vector<std::string> write_tum_directory(const std::string& directory, const Values& values,
                                             const std::unordered_map<Key, double>& times);

}  // namespace holdfast
