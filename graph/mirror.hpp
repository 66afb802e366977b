// Mirror images: points that ranges alone place, from others that all lie in one plane (in space) or on one line (in the plane).
// What is measured is the same on the other side, so that a cost cannot say which side is true: a prior, a bearing, or a measurement from
// elsewhere does.
#pragma once

#include <holdfast/graph/graph.hpp>
#include <vector>

namespace holdfast {

/// Free points (Point2, Point3) that factors tie together, none of them under a factor of its own (a prior), and what they hang from.
struct MirrorImage {
  std::vector<Key> points;   ///< those that are mirrored together, sorted
  std::vector<Key> anchors;  ///< the other variables of their factors, sorted; all in one plane or on one line
  Eigen::VectorXd origin;    ///< a point of the plane or line, 2 or 3 coordinates [m]
  Eigen::VectorXd normal;    ///< of the plane or line, of length 1
};

/// Every group of points whose mirror image fits as well, judged at these values:
///   - the anchors' thickness across the plane or line is at most 1e-3 of their extent in it, and they span it (two different ones in the
///     plane, three not on a line in space);
///   - the cost of the points' factors is the same on both sides: to 1 (a χ² of 2) or 1e-6 of it at the values, and to 1 % where the
///     points are moved off by the anchors' extent, so that points in the plane itself say nothing wrong.
/// Cost: three evaluations of the graph. Throws BadKey, BadType.
std::vector<MirrorImage> mirror_images(const Graph& graph, const Values& values);

/// The values with the points of one of them on the other side.
Values mirrored(const Values& values, const MirrorImage& image);

}  // namespace holdfast
