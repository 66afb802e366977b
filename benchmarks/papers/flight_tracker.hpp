// Our estimator on paper B's problem: eight followers, each at an unknown turn rate that is learned.
//
// It is the library's Window (solvers/window/window.hpp), twice, on Turning2 states with the motion CoordinatedTurn. A state every
// `spacing` samples is enough for a drone that flies smoothly; a sample τ after it measures p + τ v (τ ≤ 0.5 s: what the turn adds to that,
// ½ v ω τ² = 1 mm, is left out), under a robust loss.
//   now     max_states = 1: the latest state, its samples so far, and the arrival cost of all before; a step at every sample
//   later   max_states = `window`: a step whenever a state is complete
// A sample is flagged as an outlier where it is further than `outlier` from its state when that is complete.
#pragma once

#include <holdfast/factors/coordinated_turn.hpp>
#include <holdfast/factors/huber_measurement.hpp>
#include <holdfast/solvers/window/window.hpp>
#include <vector>

namespace holdfast::bench {

struct FlightTrackerOptions {
  Loss loss = Huber{2.5};    ///< of a sample
  double R = 0.7;            ///< of a sample, each axis [m²]
  double q = 2e-6;           ///< [m²/s³]
  double q_turn = 5e-6;      ///< [rad²/s³]
  double sigma_turn = 0.03;  ///< of the first turn rate [rad/s]
  int spacing = 16;          ///< samples a state
  int window = 6;            ///< states
  bool looks_back = true;    ///< false: lag 0 alone
  double outlier = 3.5;      ///< [m]: GPS has 1 m
  std::string backend = "irls";
  double cost_tolerance = 0;  ///< of a solve: to the last digit, so that every back-end gives the same numbers
};

class FlightTracker {
 public:
  /// dt: between two samples [s]; start: of each follower, known to 1 m and 0.3 m/s on each axis.
  FlightTracker(double dt, const std::vector<Motion2>& start, const FlightTrackerOptions& options);
  FlightTracker(const FlightTracker&) = delete;
  FlightTracker& operator=(const FlightTracker&) = delete;

  /// A sample of each follower [m].
  void step(const std::vector<Vector<2>>& gps);

  /// Now, from all that came.
  Motion2 state(std::size_t follower) const { return now_.state_at<Turning2>(agent(follower), step_ * dt_).motion(); }
  Matrix<4, 4> covariance(std::size_t follower) const {
    return now_.covariance_at<Turning2>(agent(follower), step_ * dt_).topLeftCorner<4, 4>();
  }
  /// So many samples ago, from all that came until the latest complete state; not before the first state of the window.
  Motion2 smoothed(std::size_t follower, int steps_ago) const {
    return later_.state_at<Turning2>(agent(follower), (step_ - steps_ago) * dt_).motion();
  }

  /// Flagged samples, by follower and step.
  struct Flag {
    std::size_t follower;
    int step;
  };
  const std::vector<Flag>& flags() const { return flags_; }
  /// Samples that have been judged.
  int judged() const { return judged_; }

 private:
  static Agent agent(std::size_t follower) { return Agent('S', follower); }
  Window window_of(int states, const std::vector<Motion2>& start);
  /// Adds samples of a follower, the first of them at the time of its state.
  void add(Window& window, std::size_t follower, double time, const std::vector<Vector<2>>& gps, std::size_t from = 0) const;
  HuberMeasurement<Turning2> sample(std::size_t i, const Vector<2>& gps) const;
  void judge(std::size_t follower, const Turning2& state);

  const double dt_;
  const FlightTrackerOptions options_;
  Window now_, later_;
  std::vector<std::vector<Vector<2>>> gps_;  ///< by follower, of the latest state
  int step_ = -1;
  std::vector<Flag> flags_;
  int judged_ = 0;
};

}  // namespace holdfast::bench
