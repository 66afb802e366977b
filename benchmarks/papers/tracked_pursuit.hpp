// Our estimator on paper A's problem: where it thought the target was, how sure it was, and how good that is.
//
// It is the library's Window (solvers/window/window.hpp) with these options: a window of the measured states with a redescending loss and
// an arrival cost, noise along and across the way the target goes, and an eye on itself (solvers/window/lock.hpp).
#pragma once

#include <deque>
#include <holdfast/benchmarks/papers/paper.hpp>
#include <holdfast/benchmarks/papers/pursuit.hpp>
#include <holdfast/factors/white_acceleration.hpp>
#include <holdfast/solvers/window/window.hpp>

namespace holdfast::bench {

constexpr int kStartUp = 60;  // steps that a tracker may take to find its target

struct TrackerOptions {
  Loss loss = TruncatedSquares{3.5};  ///< of a measurement
  Steering<Motion2> motion;
  int window = 30;  ///< measured states
  LockOptions lock;
  std::string backend = "irls";  ///< polished (polish.hpp)
};

class PursuitTracker {
 public:
  /// dt: of a step [s]; Q [m²]: of each camera.
  PursuitTracker(double dt, std::vector<Matrix<2, 2>> Q, const TrackerOptions& options);
  PursuitTracker(const PursuitTracker&) = delete;
  PursuitTracker& operator=(const PursuitTracker&) = delete;

  /// Every step, in order: a sighting of each camera, received or not. Nothing is known before the first that is received.
  void step(const std::vector<Sighting>& sightings);
  /// The state so many steps ago, from all that came since.
  Motion2 state(int steps_ago = 0) const { return window_.state_at<Motion2>('A', (step_ - steps_ago) * dt_); }
  Matrix<4, 4> covariance() const { return window_.covariance_at<Motion2>('A', step_ * dt_); }
  int reacquisitions() const { return reacquisitions_; }

  /// What became of a measurement whose state has left the window: rejected, or not.
  struct Decision {
    int step;
    std::size_t camera;
    bool rejected;
  };
  const std::vector<Decision>& decisions() const { return decisions_; }

 private:
  void decide(Key leaving);

  const double dt_;
  const std::vector<Matrix<2, 2>> Q_;
  const TrackerOptions options_;
  Window window_;
  int step_ = -1;
  int reacquisitions_ = 0;
  struct Seen {
    Key state;
    int step;
    std::size_t camera;
    Vector<2> z;
  };
  std::deque<Seen> seen_;  ///< by the states in the window
  std::vector<Decision> decisions_;
};

/// Of a pursuit whose noise is known.
std::unique_ptr<PursuitTracker> tracker_of(const Pursuit& pursuit, const TrackerOptions& options);

/// What a tracker said on the way: positions at lag 0 and at a lag of 1 s (from the 20th step on), and how sure it was.
struct Tracked {
  Positions now, late;
  double microseconds = 0;
  double nees = 0;  ///< Σ eᵀ P⁻¹ e / 4
  int samples = 0;
};

Tracked track(PursuitTracker& tracker, const Pursuit& pursuit);

/// Ours from step `first` on, at lag 0, then at a lag of 1 s.
std::vector<Score> scored(const Pursuit& pursuit, int first, const TrackerOptions& options);

}  // namespace holdfast::bench
