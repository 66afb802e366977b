// From a graph that no file made to a dataset, which writers take.
//
//   write_g2o("graph.g2o", to_dataset(graph, values, Format::G2o));
#pragma once

#include <holdfast/graph/files/dataset.hpp>
#include <holdfast/graph/graph.hpp>

namespace holdfast {

/// Between, Prior, RelativePoint and Range of poses and points, without time stamps, the noise in the convention of `format`; fixed
/// variables become FIX. BadOption names what no file holds: another factor or variable type, a loss, a weight. (What the chosen format
/// cannot hold, its writer names.)
Dataset to_dataset(const Graph& graph, const Values& values, Format format);

}  // namespace holdfast
