// `holdfast bench papers-b`: Table 2 of paper B, reproduced; then our estimator on the same data, and all of them on a true mixture.
#include <Eigen/LU>
#include <holdfast/benchmarks/papers/cpu_watch.hpp>
#include <holdfast/benchmarks/papers/flight_tracker.hpp>
#include <holdfast/benchmarks/papers/paper.hpp>
#include <holdfast/benchmarks/papers/rivals_b.hpp>

namespace holdfast::bench {
namespace {

constexpr int kLag = 62;  // samples: 2 s

/// Where everybody starts: at the first GPS fix, with the true velocity.
Motion2 start_of(const Flight& flight, std::size_t follower) {
  Motion2 start = flight.truth[follower][0];
  for (int axis = 0; axis < 2; ++axis) start.value[2 * axis] = flight.gps[follower][0][axis];
  return start;
}

/// √ of the mean square of the 2D error over followers and steps.
class Error {
 public:
  void add(const Vector<4>& estimate, const Motion2& truth) {
    sum_ += (Motion2(estimate).position() - truth.position()).squaredNorm();
    ++count_;
  }
  double rmse() const { return std::sqrt(sum_ / count_); }

 private:
  double sum_ = 0;
  int count_ = 0;
};

Score filtered(const Flight& flight, const FilterBOptions& options) {
  Error error;
  const CpuWatch watch;
  int alarms = 0;
  for (std::size_t f = 0; f < flight.gps.size(); ++f) {
    ImmB filter(options, start_of(flight, f));
    for (int k = 0; k < flight.options.steps; ++k) {
      filter.step(flight.gps[f][k]);
      error.add(filter.state().mean, flight.truth[f][k]);
    }
    alarms += filter.chi_square_alarms();
  }
  Score score{error.rmse(), 1e6 * watch.seconds() / flight.options.steps};
  if (options.kind == FilterB::arkf) score.more["χ² alarms"] = alarms;
  return score;
}

/// Ours at lag 0, then 2 s later.
std::vector<Score> tracked(const Flight& flight, const FlightTrackerOptions& options) {
  constexpr int kSample = 1000;  // samples between two errors that know nothing of each other
  const std::size_t followers = flight.gps.size();
  const int first_late = (options.window + 1) * options.spacing;
  std::vector<Motion2> start;
  for (std::size_t f = 0; f < followers; ++f) start.push_back(start_of(flight, f));
  FlightTracker tracker(kFlightStep, start, options);
  std::vector<Vector<2>> gps(followers);
  Error now, late;
  double nees = 0, microseconds = 0;
  int samples = 0;
  for (int k = 0; k < flight.options.steps; ++k) {
    for (std::size_t f = 0; f < followers; ++f) gps[f] = flight.gps[f][k];
    const CpuWatch watch;
    tracker.step(gps);
    microseconds += 1e6 * watch.seconds() / flight.options.steps;
    for (std::size_t f = 0; f < followers; ++f) {
      now.add(tracker.state(f).value, flight.truth[f][k]);
      if (options.looks_back && k >= first_late) late.add(tracker.smoothed(f, kLag).value, flight.truth[f][k - kLag]);
      if (k % kSample != kSample - 1) continue;
      const Vector<4> error = tracker.state(f).value - flight.truth[f][k].value;
      nees += error.dot(tracker.covariance(f).inverse() * error) / 4;
      ++samples;
    }
  }
  Score lag_0{now.rmse(), microseconds};
  lag_0.more["anees"] = nees / samples;
  if (!options.looks_back) return {lag_0};
  return {lag_0, {late.rmse(), microseconds}};
}

/// Constant velocity: turn rates that are known to be none.
FlightTrackerOptions straight() {
  FlightTrackerOptions options;
  options.q = 3e-4;
  options.q_turn = 1e-16;
  options.looks_back = false;
  options.sigma_turn = 1e-7;
  return options;
}

/// The best that a look at the truth allows: noise of the true size, Gaussian, and nothing but that.
Flight gaussian(const FlightOptions& options, unsigned seed) {
  FlightOptions clean = options;
  clean.mixture = true;
  clean.alpha = 0;
  return flight(clean, seed);
}

struct Rival {
  const char* name;
  FilterB kind;
  std::vector<double> paper;  ///< R, then α: 0.5 at 0.1, 0.3, 0.5; 1.5 …; 8 …
};
const std::vector<Rival>& rivals() {
  static const std::vector<Rival> all{
      {"IMM-KF", FilterB::kf, {0.3937, 0.3394, 0.3199, 0.3255, 0.2778, 0.2555, 0.2528, 0.2168, 0.1995}},
      {"IMM-EKF", FilterB::ekf, {0.3763, 0.3115, 0.2933, 0.3781, 0.3046, 0.3012, 0.3224, 0.2781, 0.2597}},
      {"IMM-ARKF", FilterB::arkf, {0.2602, 0.2232, 0.2066, 0.2121, 0.1825, 0.1765, 0.1925, 0.1709, 0.1579}},
  };
  return all;
}
constexpr double kR[] = {0.5, 1.5, 8};

PaperTable table(const std::string& name, const std::string& what, bool mixture) {
  constexpr double kAlphas[] = {0.1, 0.3, 0.5};
  PaperTable made{name, what, {"α = 0.1", "α = 0.3", "α = 0.5"}, {}, {}};
  for (const Rival& rival : rivals())
    for (int i = 0; i < 3; ++i) {
      char row[40];
      std::snprintf(row, sizeof row, "%s, R = %g", rival.name, kR[i]);
      const auto first = rival.paper.begin() + 3 * i;
      made.rows.push_back({row, mixture ? std::vector<double>() : std::vector<double>(first, first + 3)});
    }
  for (const char* ours : {"ours, constant velocity", "OURS, turning", "OURS, turning, 2 s lag"}) made.rows.push_back({ours});
  if (mixture) made.rows.push_back({"floor: OURS, Gaussian noise alone"});
  made.run = [mixture, alphas = std::vector<double>(kAlphas, kAlphas + 3)](std::size_t column, unsigned seed) {
    FlightOptions options;
    options.alpha = alphas[column];
    options.mixture = mixture;
    const Flight flight = bench::flight(options, seed);
    std::vector<Score> scores;
    for (const Rival& rival : rivals())
      for (const double R : kR) scores.push_back(filtered(flight, {rival.kind, R, 0.01}));
    for (const FlightTrackerOptions& recipe : {straight(), FlightTrackerOptions()})
      for (const Score& score : tracked(flight, recipe)) scores.push_back(score);
    if (mixture) scores.push_back(tracked(gaussian(options, seed), {}).front());
    return scores;
  };
  return made;
}

std::vector<PaperTable> tables() {
  const std::string scenario =
      "Two circles of 20 m at 0.4 m/s, 8 followers, 9818 samples of 0.032 s (half a figure of eight, from anywhere on it); RMS of the 2D "
      "error over followers and "
      "samples [m], start-up "
      "included; "
      "µs/step: all eight followers. Rivals: Q = 0.01 I, Π = 0.4/0.3/0.3. OURS: one setting for all cells: R = 0.7 m², Huber 2.5, a state "
      "every 16 "
      "samples, q = 2e-6 m²/s³, q_turn = 5e-6 rad²/s³. ";
  return {table("Table 2", scenario + "Noise as printed: α t_ν + (1 − α) g, ν ~ U(25, 50).", false),
          table("A true mixture", scenario + "Noise: t with ν = 3 in a share α of the samples, else N(0, 1).", true)};
}

}  // namespace

bool bench_paper_b(const RunnerOptions& options, Journal& journal, Terminal& terminal) {
  return run_tables("papers-b", tables(), options, journal, terminal);
}

}  // namespace holdfast::bench
