// Ranges that agree with each other: a filter before any back-end, as consistent_loops is for loop closures. Echoes are refused without a
// start, and before they have bent the map.
//
//   const ConsistentRanges found = consistent_ranges(graph);
//   for (FactorId id : found.rejected) graph.remove(id);
//
// By geometry. Three ranges (in the plane; four in space) place a beacon, and one more over-determines it: a set of four in the plane
// agrees or does not. Forsgren, Vasudevan, Kaess, McLain & Mangelson ("Group-k consistent measurement set maximization", 2022) look for
// the largest set all of whose fours agree. Here: for the largest set that agrees with one place.
//
// Poses of one agent that odometry ties in their order form a track; p_i is a pose's position by dead reckoning, in the frame of its
// track. Of the ranges between a track and one point x (it need not be known), r_i agrees with x where
//
//   (‖x − p_i‖ − r_i)² / (σ_i² + v_i)  <  the (1 − false_alarm) quantile of χ² with 1 degree of freedom
//
// v_i: the variance, an axis, of p_i as seen from the middle pose c of its window. With the odometry's own variances along the way
// between them, per axis in translation (V) and in heading (H):  v_i = V + H ‖p_i − p_c‖² / 3.  A window is the ranges around c, `window`
// of them at most, whose v_i is at most `drift` squared times σ_i². In each, places are proposed where the circles of two of its ranges
// cross (spheres of three in space), in turn about all over the window; the place that most ranges agree with is refined by Gauss-Newton
// over them, and counted anew. Windows follow each other by a quarter of their length, and a range goes where more windows reject it than
// keep it. A window whose largest set is smaller than dim + 2, or has fewer than `least_share` of its ranges, judges nobody.
//
// Between two tracks in the plane, x and the angle θ are unknown, R(θ) q_i + x stands for x, q_i being the second track's own position:
// four ranges place it, five over-determine it. θ is tried at `turns` angles. In space between two tracks nothing is judged.
//
// The test is as good as the odometry's covariances: where they are too large, as is common in public files, echoes agree with anything.
// noise_scale multiplies them. By default it is estimated: the scale at which the lower quartile of r²/(σ² + scale v) over all that
// agrees is the 40 % quantile of χ² (right where five in eight of them are true, too small by 2.7 at most where all are), times 3 to be
// safe; three times over, since a smaller scale shows better what agrees. It is never above 1.
//
// What it cannot see. Ranges that are all too long by the same offset in a window agree with each other, and nearly with a place. True
// ranges from a standing robot agree with a whole circle: they are kept, as are echoes that agree with them. Terms are looked at whatever
// their loss.
#pragma once

#include <holdfast/graph/graph.hpp>

namespace holdfast {

struct RangeConsistencyOptions {
  double false_alarm = 1e-3;       ///< in (0, 1): probability that a true range is taken to disagree with the place
  int window = 40;                 ///< >= 8: ranges
  double drift = 2;                ///< > 0: of the odometry within half a window, in sigmas of the range
  double least_share = 0.25;       ///< in (0, 1]: of a window's ranges that have to agree
  int proposals = 400;             ///< >= 1: places proposed in a window; between two tracks a quarter as many for each angle
  int turns = 24;                  ///< >= 4: angles that are tried between two tracks
  double noise_scale = 0;          ///< >= 0: of the odometry's covariances; 0: estimated
  std::vector<FactorId> odometry;  ///< empty: the relative poses between poses of one agent that follow each other by step

  /// Throws BadOption with field, value and rule.
  void validate() const;
};

struct ConsistentRanges {
  std::vector<FactorId> kept, rejected;  ///< all ranges, in the graph's order
  std::size_t untested = 0;              ///< of the kept ones: no window judged them
  std::size_t groups = 0;                ///< pairs of a track and a point, or of two tracks, that were looked at
  std::size_t windows = 0, decided = 0;  ///< and how many of them judged
  double noise_scale = 1;                ///< that was used
  double seconds = 0;
  std::string str() const;
};

/// Ranges: factors whose residual is (‖p_b − p_a‖ − distance) / sigma between two positions, of weight > 0. Throws BadOption; BadKey where
/// an id of `odometry` is not in the graph; BadType where it is no relative pose. One thread; the same answer each time.
ConsistentRanges consistent_ranges(const Graph& graph, const RangeConsistencyOptions& options = {});

}  // namespace holdfast
