// Our tracker of paper A over a pursuit: where it thought the target was, how sure it was, and how good that is.
#pragma once

#include <holdfast/benchmarks/papers/paper.hpp>
#include <holdfast/benchmarks/papers/robust_tracker.hpp>

namespace holdfast::bench {

constexpr int kStartUp = 60;  // steps that a tracker may take to find its target

RobustTracker tracker_of(const Pursuit& pursuit, const TrackerOptions& options);

/// What a tracker said on the way: positions at lag 0 and at a lag of 1 s (from the 20th step on), and how sure it was.
struct Tracked {
  Positions now, late;
  double microseconds = 0;
  double nees = 0;  ///< Σ eᵀ P⁻¹ e / 4
  int samples = 0;
};

Tracked track(RobustTracker& tracker, const Pursuit& pursuit);

/// Ours from step `first` on, at lag 0, then at a lag of 1 s.
std::vector<Score> scored(const Pursuit& pursuit, int first, const TrackerOptions& options);

}  // namespace holdfast::bench
