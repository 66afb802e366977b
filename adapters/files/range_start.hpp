// Landmarks that only ranges know, found without a guess.
#pragma once

#include <holdfast/graph/files/dataset.hpp>

namespace holdfast {

/// The dataset with a vertex for every key that only ranges name: the poses are where vertex_start puts them (dead reckoning where they
/// have no vertex), and the point is the best of several descents that begin on a circle (sphere) round the pose of the shortest range,
/// under a Cauchy loss. On a straight path a point and its mirror image fit alike, and one of them is taken. A range between two such keys
/// does not help to find either.
Dataset located_by_ranges(const Dataset& dataset);

}  // namespace holdfast
