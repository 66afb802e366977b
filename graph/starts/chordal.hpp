// The chordal start of a pose graph (Carlone et al., ICRA 2015): two linear problems, no first guess, no local minima.
//
//   1. rotations      min Σ κ_ij ‖R_j − R_i R_ij‖²_F over matrices, not rotations; then each R_i to the nearest rotation (SVD)
//   2. translations   min Σ ‖t_j − t_i − R_i t_ij‖² in the information of the edge, with these rotations
//
// κ is the mean of the diagonal of the edge's rotational information. Where measurements are exact, so is the answer, however long the
// loops are; with noise it is near a minimum where dead reckoning has drifted far from it. Losses are not looked at: an outlier pulls.
//
// Each part that relative poses connect is solved for itself, held at its fixed poses, else at its lowest pose with a prior (at the
// prior), else at its lowest pose, all but the prior where vertex_start has them. Moving what is held moves the part rigidly.
#pragma once

#include <holdfast/graph/graph.hpp>
#include <holdfast/graph/starts/start.hpp>

namespace holdfast {

/// Poses as above; every other key, and a part that cannot be solved (a singular information matrix), as in vertex_start.
Values chordal_start(const Dataset& dataset);

/// The same of a graph, from its factors that say relative_pose() (factor.hpp); a part without a fixed pose is held where its lowest pose
/// is now, other factors are not looked at. False, and the values as they were, where that leaves a free variable without a place.
bool chordal_start(const Graph& graph, Values& values);

}  // namespace holdfast
