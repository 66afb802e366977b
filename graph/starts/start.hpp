// Where a solve may start: Values made from a Dataset. Both starts hold every key that a vertex or an edge names.
//
// A pose without a value of its own gets one from its neighbours over the relative poses, composed one after the other:
// x_second = x_first · measured, or x_first = x_second · measured⁻¹. Odometry goes first: another edge is used only where no
// odometry edge leads on; among several the first in the file counts. Where no edge leads on, the lowest pose left that has a vertex
// starts again there; when none is left, the lowest pose at its prior, or at the identity without one.
// A landmark without a vertex is put where the first relative point puts it that names it, else at its prior, else where a bearing puts it:
// at the range from the same pose if there is one, else where two bearings meet, else 1 m away.
// BadKey names a key that only ranges know: they say not where it is, give it a vertex.
#pragma once

#include <holdfast/graph/files/dataset.hpp>
#include <holdfast/graph/values.hpp>
#include <string>
#include <vector>

namespace holdfast {

/// Which relative poses are odometry.
struct OdometryRule {
  enum class Kind { consecutive, none, tag };
  Kind kind = Kind::consecutive;
  std::string tag = {};  ///< kind tag: the relative poses whose lines have this tag
};

/// "consecutive", "none", or a tag.
OdometryRule odometry_rule(const std::string& text);

/// For each edge of the dataset: is it odometry? By the rule `consecutive`, a relative pose between one pose of an agent and the next pose
/// this agent has (by step; steps may have gaps), in either direction. Agents are pairs of kind and number, so ids that are symbols keep
/// robots apart; the poses 0, 1, … of a g2o or TORO file are of one agent, whose sessions are told apart:
///   - over a gap in the steps of more than 5 × the agent's median gap (steps of other variables do not count) there is none;
///   - nor where the vertices say that the next pose begins elsewhere: they are more than 3 × the agent's median step apart, the edge and
///     they differ by more than that step, by more than 10 sigma, and by more than 10 × the median of its other edges. Where more than 2
///     and 1 % of an agent's edges were so, its vertices are a poor start and say nothing of sessions.
/// A switchable or mixture edge is none. BadOption where the rule is a tag that no relative pose has.
std::vector<bool> odometry_edges(const Dataset& dataset, const OdometryRule& rule = {});

/// The vertices of the file; poses and landmarks without one are completed from the edges.
Values vertex_start(const Dataset& dataset);

/// Dead reckoning: each agent starts at the first of its poses that has a vertex (its first pose, at the identity, if none has) and
/// follows its odometry from there: consecutive poses differ by the measured step to rounding. A gap in the odometry is bridged
/// over other edges (also other agents' poses), else the agent starts again at the vertex behind the gap.
/// Landmarks start at their vertex + N(0, landmark_sigma² [m²]) per axis: the same for the same seed on every platform, and whatever the
/// order of the file. BadNumber where landmark_sigma is negative or not finite.
Values odometry_start(const Dataset& dataset, unsigned seed, double landmark_sigma = 1.0);

}  // namespace holdfast
