// From a file's records to a graph to solve, and from values back to records.
#pragma once

#include <holdfast/graph/files/dataset.hpp>
#include <holdfast/graph/graph.hpp>
#include <holdfast/graph/starts/start.hpp>
#include <holdfast/solvers/convex_start.hpp>
#include <optional>

namespace holdfast {

struct ProblemOptions {
  enum class Start { file, odometry, chordal, convex };
  Loss loss;                   ///< of every measurement but the odometry between consecutive poses and the priors
  Start start = Start::file;   ///< vertex_start or odometry_start (graph/starts/start.hpp), chordal_start (graph/starts/chordal.hpp), or
                               ///< relaxed_start (solvers/convex_start.hpp) with the rotations of chordal_start
  unsigned seed = 0;           ///< of the landmarks' start in odometry_start
  OdometryRule odometry = {};  ///< which relative poses are odometry, and so under no loss
};

/// "file", "odometry", "chordal" or "convex"; else BadOption.
ProblemOptions::Start start_named(const std::string& name);

struct Problem {
  Graph graph;
  Values start;
  std::vector<FactorId> factors;        ///< one per edge of the dataset, in its order
  std::optional<RelaxedStart> relaxed;  ///< how a convex start was found
};

/// Relative poses become Between, ranges Range, bearings VonMisesBearingBody, relative points RelativePoint, priors Prior (of positions
/// alone, too). What holds the world in place: FIX lines of variables that there are, and priors of the file, else: PyFG (whose vertices
/// are truth): a prior on the first pose of each agent, at its vertex, with the sigmas of the agent's first odometry edge; g2o and TORO:
/// the lowest pose is fixed.
/// Throws BadNumber or BadKey naming the culprit, BadProblem where a convex start fails.
Problem make_problem(const Dataset& dataset, const ProblemOptions& options = {});

/// The dataset with its vertices replaced by the values (missing ones added): ready to be written.
Dataset with_values(const Dataset& dataset, const Values& values);

}  // namespace holdfast
