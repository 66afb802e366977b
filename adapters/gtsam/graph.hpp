// Whole graphs to GTSAM and back. Link holdfast::gtsam.
//
//   gtsam::NonlinearFactorGraph theirs = to_gtsam(graph, values);
//   Graph ours = from_gtsam(theirs);
#pragma once

#include <holdfast/adapters/gtsam/gtsam.hpp>

namespace holdfast {

/// Every factor of the graph; fixed variables are constants in them, at `values`, and a factor of fixed variables alone is a BadOption.
/// Factors of types that no file has refer to `graph`.
gtsam::NonlinearFactorGraph to_gtsam(const Graph& graph, const Values& values);

/// Our factors come back as they went. GTSAM's own BetweenFactor and PriorFactor of poses under Gaussian noise become ours: of the same
/// error for Pose2, and for Pose3 of the same up to second order in it (GTSAM takes the logarithm of SE(3), we that of SO(3)). BadOption
/// names any other factor.
Graph from_gtsam(const gtsam::NonlinearFactorGraph& theirs);

}  // namespace holdfast
