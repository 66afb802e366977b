// How good an answer is, apart from its cost.
#pragma once

#include <cstddef>
#include <holdfast/graph/graph.hpp>
#include <optional>

namespace holdfast::common {

/// Root mean square of ‖position − true position‖ over all variables of `truth` that have a position, of all agents together [m].
struct PositionError {
  double ate_rmse;  ///< after the best rigid motion (rotation and translation, no scale, no mirror) of the whole estimate onto the truth
  double rmse;      ///< as it stands: the frame is that of the truth where a prior holds it there
  std::size_t positions;  ///< how many entered
};

/// ATE as it is usual (Sturm et al. 2012), but with ONE motion for all agents: where they are to each other counts. It leaves out
/// what a first heading off by its sigma does to the far end of a map; rmse has that, too.
/// `truth` holds what is to be scored and nothing else: the poses of a file (landmarks are not scored), the states of a
/// scenario. Keys without an estimate and those of another space than the first are left out. Nothing where none is left.
std::optional<PositionError> position_error(const Values& truth, const Values& estimate);

/// T_truth_estimate, homogeneous, square with a side of 3 in the plane and 4 in space: the rigid motion that the ATE is taken after.
/// Nothing where no variable of `truth` has a position.
std::optional<Eigen::MatrixXd> alignment(const Values& truth, const Values& estimate);

/// How many factors a graph's losses judge, and reject at these values (is_rejected, solvers/outlier_report.hpp): those under another
/// loss than squared, loop closures and landmarks as well as ranges; and of them the ranges (factors whose name begins with "Range";
/// under the squared loss, too).
struct RejectedCount {
  std::size_t judged = 0, rejected = 0;
  std::size_t ranges = 0, rejected_ranges = 0;
};
RejectedCount count_rejected(const Graph& graph, const Values& values);

}  // namespace holdfast::common
