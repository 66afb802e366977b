// Loop closures that agree with each other: a filter before any back-end. False loops that agree among themselves defeat every loss that
// looks at one term at a time; but they do not agree with the true ones.
//
//   const ConsistentLoops found = consistent_loops(graph);
//   for (FactorId id : found.rejected) graph.remove(id);
//
// Pairwise consistent measurements (PCM; Mangelson, Dominic, Eustice & Vasudevan, ICRA 2018), within one robot and between two. Poses tied
// by odometry form tracks; T_k is a pose of a track by dead reckoning. A loop z from pose a of a track to pose b of the same or another one
// says how the second's dead reckoning lies in the first's: X = T_a z T_b⁻¹. Two loops between the same tracks agree where, with
//
//   e = Log(X₁ X₂⁻¹)       χ² = eᵀ Σ⁻¹ e  <  the (1 − false_alarm) quantile of χ² with dim degrees of freedom
//
// Log is that of SE(n); Σ is propagated to first order in its tangent, in the frame of the first track: both loops' own noise, and the
// odometry between their ends, A on the first track, B on the second, with what a stretch that both ends have run over has in common (C):
//
//   Σ = Ad(T_a z) Σ_z Ad(T_a z)ᵀ of each + A + Ad(X) B Ad(X)ᵀ ∓ (C Ad(X)ᵀ + Ad(X) C)
//
// all from cumulative sums, so a pair costs the same however far apart its ends are. Of each pair of tracks the largest set of loops
// without a disagreement is kept, a maximum clique: exact within time_limit, else the best set found by greedy choice and swaps.
//
// A second look goes beyond pairs. A false group that dead reckoning cannot tell from the truth, or that outnumbers the true loops
// near it, still does not fit the map. 24 maps are made, each the tree of least uncertain paths over the odometry and a random half of the
// kept loops (at first of those that most others support), and each other loop is asked whether it agrees with the way between its ends,
// by the same test, where that is known well (a third of `informative`), and unless the map holds a twin of it: a loop whose ends are
// within 25 poses of its own, since twins stand and fall together. A loop that at least three maps judge, and 95 % of them reject, goes;
// then new maps are made of what is left, seven times in all, the last two rejecting what half of them do. What the pairs had rejected
// comes back where a quarter at most reject it.
//
// Which pairs are tried. Where odometry has turned by an unknown angle any two loops agree: pairs with more than `informative` radians of
// standard deviation of the heading between their ends (both tracks together) are not tried and count as agreeing; where more than
// most_pairs would be tried, the limit is lowered. A loop without any pair that was tried is kept and counted as untested: what a
// loop alone can say is left to the loss, or to gnc. Loops between different pairs of tracks are not compared.
//
// The test is as good as the covariances: too small ones reject what is true, too large ones, common in public graphs, make it blind.
// noise_scale multiplies all of them. By default it is estimated, as the variance factor of an adjustment: the 20 % quantile of the χ² of
// all pairs over the 40 % quantile of their distribution (right where half of the pairs are of two true loops, within a factor of 3 where
// a quarter are, or all), times 3 to be safe. It is never above 1: covariances are not enlarged.
#pragma once

#include <holdfast/graph/graph.hpp>

namespace holdfast {

struct PairwiseConsistencyOptions {
  double false_alarm = 1e-4;            ///< in (0, 1): probability that two true loops are taken to disagree
  bool second_look = true;              ///< the vote of the maps
  double informative = 1;               ///< > 0 [rad]
  std::size_t most_pairs = 20'000'000;  ///< >= 1
  double time_limit = 0.5;              ///< >= 0 [s] of the exact search, for each pair of tracks; 0: greedy
  double noise_scale = 0;               ///< >= 0: of every covariance; 0: estimated
  /// The odometry. Empty: the relative poses between poses of one agent that follow each other by step.
  std::vector<FactorId> odometry;

  /// Throws BadOption with field, value and rule.
  void validate() const;
};

struct ConsistentLoops {
  std::vector<FactorId> kept, rejected;  ///< all loops, in the graph's order
  std::size_t untested = 0;              ///< of the kept ones
  std::size_t tracks = 0, groups = 0;    ///< tracks; pairs of tracks with two loops or more
  std::size_t pairs = 0, disagreeing = 0;
  double informative = 0;  ///< [rad] the limit that was used
  double noise_scale = 1;  ///< that was used
  bool is_exact = true;    ///< every group's set is the largest there is
  double seconds = 0;
  std::string str() const;
};

/// Loops: relative poses (factors that say relative_pose()) that are not odometry, whatever their loss, of weight > 0. Other factors
/// are not looked at. A direction without information counts as 1e-9 of the largest. Throws BadOption; BadKey where an id of `odometry`
/// is not in the graph; BadType where it is no relative pose.
ConsistentLoops consistent_loops(const Graph& graph, const PairwiseConsistencyOptions& options = {});

/// Of these loops, in a graph that still has them, those that agree with an answer found without them: ‖r‖² below the (1 − false_alarm)
/// quantile of χ². A true loop that disagreed with others comes back so:
///
///   Graph kept = graph;  for (FactorId id : found.rejected) kept.remove(id);  backend->solve(kept, values);
///   agreeing_loops(graph, values, found.rejected)                              // not to be removed after all: solve again
///
/// Throws BadKey, BadType; BadOption where false_alarm is not between 0 and 1.
std::vector<FactorId> agreeing_loops(const Graph& graph, const Values& values, const std::vector<FactorId>& loops,
                                     double false_alarm = 0.01);

}  // namespace holdfast
