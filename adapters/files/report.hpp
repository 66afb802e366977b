// What a file's lines were taken for, and what is odd about them: for the user, before a solve.
#pragma once

#include <holdfast/graph/check.hpp>
#include <holdfast/graph/files/dataset.hpp>
#include <holdfast/graph/starts/start.hpp>

namespace holdfast {

/// One line: "664 odometry edges (written backwards), 12 loop closures, 664 position priors; 3 lines of VERTEX_TAG kept, not used".
/// Kinds in a fixed order, those of which there are none left out.
std::string use_report(const Dataset& dataset, const OdometryRule& rule = {});

/// What is odd about the dataset, each kind once: FIX lines that name no vertex, poses of an agent at one time or in decreasing time,
/// matrices that were repaired (every line, by how much), edges without an information, ODOMETRY of iSAM whose noise could be another.
std::vector<Finding> check(const Dataset& dataset);

}  // namespace holdfast
