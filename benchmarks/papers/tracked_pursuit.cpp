#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <holdfast/benchmarks/papers/cpu_watch.hpp>
#include <holdfast/benchmarks/papers/polish.hpp>
#include <holdfast/benchmarks/papers/tracked_pursuit.hpp>
#include <holdfast/factors/huber_measurement.hpp>
#include <holdfast/factors/prior.hpp>

namespace holdfast::bench {
namespace {

constexpr int kLag = 20;            // steps: 1 s
constexpr double kAnywhere = 1000;  // σ of the first position [m]

/// Precision and recall of flagged outliers; nothing where there are none.
void judge(const Pursuit& pursuit, const PursuitTracker& tracker, Json& more) {
  int hits = 0, false_alarms = 0, missed = 0;
  for (const PursuitTracker::Decision& decision : tracker.decisions()) {
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

WindowOptions window_options(const TrackerOptions& options, std::function<void(Key)> decide) {
  WindowOptions window;
  window.max_states = options.window;
  window.on_leaving = [decide = std::move(decide)](Key key, double) { decide(key); };
  return window;
}

}  // namespace

PursuitTracker::PursuitTracker(double dt, std::vector<Matrix<2, 2>> Q, const TrackerOptions& options)
    : dt_(dt),
      Q_(std::move(Q)),
      options_(options),
      window_(window_options(options, [this](Key key) { decide(key); }), std::make_unique<Polished>(options.backend)) {
  window_.add_agent('A', options.motion);
  window_.keep_lock('A', options.lock, [speed = options.motion.speed](const Motion2& seen) {
    return Prior<Motion2>::from_sigmas(seen, {kAnywhere, speed, kAnywhere, speed});
  });
}

void PursuitTracker::step(const std::vector<Sighting>& sightings) {
  const double t = ++step_ * dt_;
  if (std::none_of(sightings.begin(), sightings.end(), [](const Sighting& sighting) { return sighting.received; })) return;
  const Key state = window_.at('A', t);
  for (std::size_t c = 0; c < sightings.size(); ++c) {
    if (!sightings[c].received) continue;
    window_.add(HuberMeasurement<Motion2>::of_position(-sightings[c].z, Vector<2>::Zero(), Q_[c]), {state}, options_.loss);
    seen_.push_back({state, step_, c, sightings[c].z});
  }
  reacquisitions_ += static_cast<int>(window_.step(t).reacquired.size());
}

void PursuitTracker::decide(Key leaving) {
  for (; !seen_.empty() && seen_.front().state == leaving; seen_.pop_front()) {
    const Seen& seen = seen_.front();
    const Vector<2> error = seen.z - window_.state<Motion2>(leaving).position();
    const double squared = error.dot(Q_[seen.camera].llt().solve(error));
    decisions_.push_back({seen.step, seen.camera, squared > options_.lock.rejected * options_.lock.rejected});
  }
}

std::unique_ptr<PursuitTracker> tracker_of(const Pursuit& pursuit, const TrackerOptions& options) {
  const double variance = pursuit.options.sigma * pursuit.options.sigma;
  const std::vector<Matrix<2, 2>> Q(pursuit.options.sensors.size(), variance * Matrix<2, 2>::Identity());
  return std::make_unique<PursuitTracker>(pursuit.options.dt, Q, options);
}

Tracked track(PursuitTracker& tracker, const Pursuit& pursuit) {
  constexpr int kSample = 50;  // steps between two errors that hardly know of each other
  const int steps = static_cast<int>(pursuit.truth.size());
  Tracked tracked;
  for (int k = 0; k < steps; ++k) {
    const CpuWatch watch;
    tracker.step(pursuit.sightings[k]);
    tracked.now.push_back(tracker.state().position());
    if (k >= kLag) tracked.late.push_back(tracker.state(kLag).position());
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
  const auto tracker = tracker_of(pursuit, options);
  const Tracked tracked = track(*tracker, pursuit);
  Score lag_0{rmse(pursuit, tracked.now, first, steps), tracked.microseconds};
  lag_0.consistency(tracked.nees / tracked.samples, 4 * tracked.samples);
  lag_0.more["second half [m]"] = rmse(pursuit, tracked.now, steps / 2, steps);
  lag_0.more["re-acquisitions"] = tracker->reacquisitions();
  judge(pursuit, *tracker, lag_0.more);
  return {lag_0, {rmse(pursuit, tracked.late, first, steps - kLag), tracked.microseconds}};
}

}  // namespace holdfast::bench
