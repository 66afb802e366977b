// Our estimator on paper A's problem: a window of the measured states with a redescending loss, an arrival cost, and an eye on itself.
//
//   cost = arrival ½‖x_first − x̄‖²_P̄ + Σ motion + Σ ½ρ(‖Q^{-1/2} (z − C x)‖²)
//
// Motion between two measured states, T apart, is white acceleration across and along the way the target goes, of the densities turn · v²
// and along · v² [m²/s³] at its speed v: what a vehicle does that steers and hardly changes speed. One setting fits slow and fast targets.
// Arrival cost: a state that leaves the window is marginalised (solvers/window/marginalize.hpp) with the weights ρ' that its measurements
// have then. A redescending loss with an arrival cost can lock onto outliers and reject all that comes after. So the tracker counts: where
// more than half of the latest measurements are rejected (beyond 3.5 sigmas), its inliers no longer explain the data. It says so
// (reacquisitions()), drops the arrival cost and solves the latest `memory` measured states from nothing by graduated non-convexity
// (gnc.hpp); whichever costs less goes on.
#pragma once

#include <deque>
#include <holdfast/benchmarks/papers/chain.hpp>
#include <holdfast/benchmarks/papers/pursuit.hpp>

namespace holdfast::bench {

struct TrackerOptions {
  Loss loss = TruncatedSquares{3.5};  ///< of a measurement
  double turn = 0.1;                  ///< [rad²/s]
  double along = 0.003;               ///< [1/s]
  double speed = 20;                  ///< σ of each axis of the velocity before anything is known; the speed v until it is [m/s]
  std::size_t window = 30;            ///< measured states
  std::size_t memory = 60;            ///< measured states, of a re-acquisition
  std::size_t recent = 8;             ///< measurements that are counted
  std::string backend = "irls";
  double cost_tolerance = 0;  ///< of a solve: to the last digit, so that every back-end gives the same numbers
};

class RobustTracker {
 public:
  /// dt: of a step [s]; Q [m²]: of each camera.
  RobustTracker(double dt, const std::vector<Matrix<2, 2>>& Q, const TrackerOptions& options);

  /// Every step, in order: a sighting of each camera, received or not. Nothing is known before the first that is received.
  void step(const std::vector<Sighting>& sightings);

  /// The latest step's state, from all that came.
  Motion2 state() const;
  /// Its covariance, given which measurements are believed.
  Matrix<4, 4> covariance() const;
  /// The state so many steps ago, from all that came since; not before the window's first.
  Motion2 smoothed(int steps_ago) const;

  /// How often graduated non-convexity found something better than what was tracked, the first acquisition not counted.
  int reacquisitions() const { return reacquisitions_; }
  /// What became of a measurement that has left the window: rejected beyond 3.5 sigmas.
  struct Decision {
    int step;
    std::size_t camera;
    bool rejected;
  };
  const std::vector<Decision>& decisions() const { return decisions_; }

 private:
  void enter(const std::vector<Sighting>& sightings);
  double solve();
  void reconsider_last();
  void drop_first();
  bool explains_the_data() const;
  void acquire();
  std::vector<ChainNode> remembered() const;
  void go_on_from(std::vector<ChainNode> found, const Prior<Motion2>& anywhere);
  bool is_rejected(const ChainNode& node, std::size_t camera) const;
  WhiteAcceleration<Motion2> motion(double T, const Motion2* from) const;
  Prior<Motion2> nothing_known(const Vector<2>& p) const;

  const double dt_;
  const TrackerOptions options_;
  const std::vector<Chain::Camera> cameras_;
  Chain chain_;
  std::unique_ptr<Backend> backend_;
  std::vector<ChainNode> nodes_;   ///< of the window
  std::deque<ChainNode> dropped_;  ///< that have left it, for a re-acquisition
  Prior<Motion2> arrival_;
  int step_ = -1;
  int measured_ = 0;
  int next_acquisition_ = 0;  ///< not before so many measured states
  int reacquisitions_ = 0;
  std::vector<Decision> decisions_;
};

}  // namespace holdfast::bench
