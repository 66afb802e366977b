#include <Eigen/LU>
#include <algorithm>
#include <holdfast/benchmarks/papers/cpu_watch.hpp>
#include <holdfast/benchmarks/papers/tracked_pursuit.hpp>

namespace holdfast::bench {
namespace {

constexpr int kLag = 20;  // steps: 1 s

/// Precision and recall of flagged outliers; nothing where there are none.
void judge(const Pursuit& pursuit, const RobustTracker& tracker, Json& more) {
  int hits = 0, false_alarms = 0, missed = 0;
  for (const RobustTracker::Decision& decision : tracker.decisions()) {
    if (decision.step < kStartUp) continue;
    const bool outlier = pursuit.sightings[decision.step][decision.camera].outlier;
    hits += decision.rejected && outlier;
    false_alarms += decision.rejected && !outlier;
    missed += !decision.rejected && outlier;
  }
  if (hits + missed == 0) return;
  more["precision"] = static_cast<double>(hits) / std::max(1, hits + false_alarms);
  more["recall"] = static_cast<double>(hits) / (hits + missed);
}

}  // namespace

RobustTracker tracker_of(const Pursuit& pursuit, const TrackerOptions& options) {
  const double variance = pursuit.options.sigma * pursuit.options.sigma;
  return {pursuit.options.dt, std::vector<Matrix<2, 2>>(pursuit.options.sensors.size(), variance * Matrix<2, 2>::Identity()), options};
}

Tracked track(RobustTracker& tracker, const Pursuit& pursuit) {
  constexpr int kSample = 50;  // steps between two errors that hardly know of each other
  const int steps = static_cast<int>(pursuit.truth.size());
  Tracked tracked;
  for (int k = 0; k < steps; ++k) {
    const CpuWatch watch;
    tracker.step(pursuit.sightings[k]);
    tracked.now.push_back(tracker.state().position());
    if (k >= kLag) tracked.late.push_back(tracker.smoothed(kLag).position());
    tracked.microseconds += 1e6 * watch.seconds() / steps;
    if (k < kStartUp || k % kSample != 0) continue;
    const Vector<4> error = tracker.state().value - pursuit.truth[k].value;
    tracked.nees += error.dot(tracker.covariance().inverse() * error) / 4;
    ++tracked.samples;
  }
  return tracked;
}

std::vector<Score> scored(const Pursuit& pursuit, int first, const TrackerOptions& options) {
  const int steps = static_cast<int>(pursuit.truth.size());
  RobustTracker tracker = tracker_of(pursuit, options);
  const Tracked tracked = track(tracker, pursuit);
  Score lag_0{rmse(pursuit, tracked.now, first, steps), tracked.microseconds};
  lag_0.consistency(tracked.nees / tracked.samples, 4 * tracked.samples);
  lag_0.more["second half [m]"] = rmse(pursuit, tracked.now, steps / 2, steps);
  lag_0.more["re-acquisitions"] = tracker.reacquisitions();
  judge(pursuit, tracker, lag_0.more);
  return {lag_0, {rmse(pursuit, tracked.late, first, steps - kLag), tracked.microseconds}};
}

}  // namespace holdfast::bench
