// Problems made from a seed: the same numbers on every platform, with their truth.
#pragma once

#include <holdfast/common/instance.hpp>

namespace holdfast::bench {

using namespace common;

/// Paper A: a unicycle at constant speed whose turn rate, U(−0.5, 0.5) rad/s, is held for 2 to 6 s, seen from the origin every step.
/// HuberMeasurement (a = 2, per component, Q = I) on every state Motion2 `A<k>` and an exact WhiteAcceleration (R = I) between two. An
/// outlier adds U(40, 70) m to both axes, always to the same side. Convex. Start: where the measurement says, at rest.
struct UnicycleOptions {
  int states = 15;
  double outliers = 0.2;  ///< probability
  double dt = 0.05;       ///< [s]
  double speed = 10;      ///< [m/s]
  double sigma = 1;       ///< [m]
};
class Random;
/// Its way: exact arcs of constant turn rate.
std::vector<Motion2> unicycle_path(const UnicycleOptions& options, Random& random);
Instance unicycle(const UnicycleOptions& options, unsigned seed);

/// Range balls alone: nodes Point2 `N<i>` anywhere in a square of 10 m × 10 m a node, a RangeBall (σ = 0.5 m) between any two nearer than
/// the radius that makes eight neighbours on average (and to the nearest, so that nobody is alone), a tenth of them anchors held by a Prior
/// of 0.1 m. Convex, but many answers may be equally good: balls only bound. Start: anywhere in the square.
Instance swarm(int nodes, unsigned seed);

/// A random geometric network: nodes Point2 `N<i>` anywhere in a square with one node a square metre, a tenth of them anchors, fixed where
/// they are, and a RangeBall between any two nearer than the radio's range r that makes eight neighbours on average; distances with 2 % of
/// noise, σ = 0.02 r. Convex. Start: all others at the centroid of the anchors.
Instance network(int nodes, unsigned seed);

/// Paper C: three nodes Motion2 `A<k>`, `B<k>`, `C<k>` move among three known anchors, step (2, 0.4) m, 50 steps; each sees each anchor and
/// each other node by range (σ = 0.5 m) and bearing (κ = 6000), both in one RangeBearingBall, and an edge loses `lost` of its measurements,
/// never two in a row nor the first (papers/network.hpp). WhiteAcceleration between steps. Convex. Start: the centre of the anchors.
Instance formation(double lost, unsigned seed);

/// A pose graph: two laps on a circle of 50 m, a pose Pose2 `A<k>` every two metres or so, odometry, and one closure in five poses between
/// the laps, 30 % of them (`false_share`) false: between two poses anywhere that are claimed to be the same. `loss` is that of the
/// closures. Start: dead reckoning.
Instance ring(int poses, const Loss& loss, unsigned seed, double false_share = 0.3);

/// Robots in the plane: poses Pose2 `A<k>`, `B<k>`, … (never L), a step of 1 m and a random turn each, back towards the middle where it is
/// more than 15 m away; odometry (σ = 0.05 m, 0.01 rad) and a Prior on every first pose. Four beacons Point2 `L0` … `L3` at the corners of
/// a square of 40 m. A Range (σ = 0.1 m) from every pose to every beacon, and between any two robots at the same step. Start: dead
/// reckoning, beacons N(0, 1 m) off. 1 to 25 agents, 2 steps or more, else BadOption.
Instance fleet(int agents, int steps, unsigned seed);

}  // namespace holdfast::bench
