// Keeping lock: an agent of a Window that notices when it follows outliers, says so, and finds its way back.
//
//   window.add_agent('A', motion);
//   window.keep_lock('A', {}, [](const Motion2& seen) { return Prior<Motion2>::from_sigmas(seen, {1000, 20, 1000, 20}); });
//   while (…) {
//     window.add(measurement, {window.at('A', t)}, TruncatedSquares{3.5});    // the first one says where A starts
//     const WindowStep& step = window.step(now);
//     if (!step.lost.empty()) …                                               // what A believes explains its measurements no longer
//     … window.state_at<Motion2>('A', now) …
//   }
//
// A redescending loss with an arrival cost can lock onto outliers and reject all that comes after. So at every step, after the solve,
//   1. a new measurement that is rejected under a loss that is not convex is tried once more, from where it is right (the shortest move of
//      its state that leaves it no residual); the cheaper answer stays.
//   2. Where more than half of the latest `recent` robust measurements are rejected, the inliers no longer explain the data: the agent
//      is in WindowStep::lost. Its latest `memory` states, those among them that have left the window, are then solved from nothing,
//      without any arrival cost, by graduated non-convexity (solvers/gnc.hpp) with truncated squares at `rejected`. Where that costs less
//      than what was believed, the window goes on from there, and the agent is in WindowStep::reacquired; what it knew of the agent
//      before is forgotten.
// Rejected: ‖r‖ > `rejected`, whatever the loss. Robust: under any loss but Squared.
//
// A re-acquisition asks one agent alone. Landmarks in its measurements are held where they are believed, and what it measured of other
// agents is left out. A motion that depends on the state it leads from (Window::add_agent) is told nothing of it in the first `settled`
// states and in a re-acquisition: there the state is what is doubted.
#pragma once

#include <holdfast/graph/graph.hpp>

namespace holdfast {

struct LockOptions {
  int memory = 60;        ///< >= 2: states before the newest one, of a re-acquisition
  int recent = 8;         ///< >= 1: measurements that are counted
  double rejected = 3.5;  ///< > 0 [sigmas]: of a residual
  int patience = 5;       ///< >= 1: states from one acquisition to the next
  int settled = 10;       ///< >= 0: states before anybody asks them how fast the agent is; acquisitions until then are not reported

  /// Throws BadOption with field, value and rule.
  void validate() const;
};

}  // namespace holdfast
