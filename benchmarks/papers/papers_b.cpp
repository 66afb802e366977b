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

std::vector<Motion2> starts_of(const Flight& flight) {
  std::vector<Motion2> start;
  for (std::size_t f = 0; f < flight.gps.size(); ++f) start.push_back(start_of(flight, f));
  return start;
}

std::vector<Vector<2>> samples_of(const Flight& flight, int step) {
  std::vector<Vector<2>> samples;
  for (const auto& follower : flight.gps) samples.push_back(follower[step]);
  return samples;
}

/// From when on the look back has an answer of 2 s ago.
int first_late(const FlightTrackerOptions& options) { return (options.window + 1) * options.spacing; }

/// Precision and recall of flagged samples: an outlier is one that is truly as far off as is flagged.
void judge(const Flight& flight, const FlightTracker& tracker, double outlier, Json& more) {
  const auto is_outlier = [&](std::size_t follower, int k) {
    return (flight.gps[follower][k] - flight.truth[follower][k].position()).norm() > outlier;
  };
  int outliers = 0, hits = 0;
  const int judged = tracker.judged() / static_cast<int>(flight.gps.size());
  for (std::size_t f = 0; f < flight.gps.size(); ++f)
    for (int k = 0; k < judged; ++k) outliers += is_outlier(f, k);
  for (const FlightTracker::Flag& flag : tracker.flags()) hits += is_outlier(flag.follower, flag.step);
  if (outliers == 0 || tracker.flags().empty()) return;
  more["precision"] = static_cast<double>(hits) / static_cast<double>(tracker.flags().size());
  more["recall"] = static_cast<double>(hits) / outliers;
}

/// Ours at lag 0, then 2 s later.
std::vector<Score> tracked(const Flight& flight, const FlightTrackerOptions& options) {
  constexpr int kSample = 1000;  // samples between two errors that know nothing of each other
  FlightTracker tracker(kFlightStep, starts_of(flight), options);
  Error now, late;
  double nees = 0, microseconds = 0;
  int samples = 0;
  for (int k = 0; k < flight.options.steps; ++k) {
    const std::vector<Vector<2>> gps = samples_of(flight, k);
    const CpuWatch watch;
    tracker.step(gps);
    microseconds += 1e6 * watch.seconds() / flight.options.steps;
    for (std::size_t f = 0; f < gps.size(); ++f) {
      now.add(tracker.state(f).value, flight.truth[f][k]);
      if (options.looks_back && k >= first_late(options)) late.add(tracker.smoothed(f, kLag).value, flight.truth[f][k - kLag]);
      if (k % kSample != kSample - 1) continue;
      const Vector<4> error = tracker.state(f).value - flight.truth[f][k].value;
      nees += error.dot(tracker.covariance(f).inverse() * error) / 4;
      ++samples;
    }
  }
  Score lag_0{now.rmse(), microseconds};
  lag_0.consistency(nees / samples, 4 * samples);
  judge(flight, tracker, options.outlier, lag_0.more);
  if (!options.looks_back) return {lag_0};
  return {lag_0, {late.rmse(), microseconds}};
}

/// Constant velocity: turn rates that are known to be none.
FlightTrackerOptions straight() {
  FlightTrackerOptions options;
  options.q = 3e-4;
  options.q_turn = 1e-12;
  options.looks_back = false;
  options.sigma_turn = 1e-5;
  return options;
}

/// The best that a look at the truth allows: noise of the true size, Gaussian, and nothing but that.
Flight gaussian(const FlightOptions& options, unsigned seed) {
  FlightOptions clean = options;
  clean.mixture = true;
  clean.alpha = 0;
  return flight(clean, seed);
}

// ---- the tables

/// One run of a column.
struct Case {
  Flight flight;
  unsigned seed;
};

constexpr double kAlphas[] = {0.1, 0.3, 0.5};
constexpr double kR[] = {0.5, 1.5, 8};

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

Contender<Case> contender(const Rival& rival, int i, bool printed) {
  char row[40];
  std::snprintf(row, sizeof row, "%s, R = %g", rival.name, kR[i]);
  const auto first = rival.paper.begin() + 3 * i;
  return {{{row, printed ? std::vector<double>(first, first + 3) : std::vector<double>()}}, [&rival, i](const Case& one) {
            return std::vector{filtered(one.flight, {rival.kind, kR[i], 0.01})};
          }};
}

std::vector<Contender<Case>> contenders(bool mixture) {
  std::vector<Contender<Case>> all;
  for (const Rival& rival : rivals())
    for (int i = 0; i < 3; ++i) all.push_back(contender(rival, i, !mixture));
  all.push_back({{{"ours, constant velocity"}}, [](const Case& one) { return tracked(one.flight, straight()); }});
  all.push_back({{{"OURS, turning"}, {"OURS, turning, 2 s lag"}}, [](const Case& one) { return tracked(one.flight, {}); }});
  FlightTrackerOptions lag_0_alone;
  lag_0_alone.looks_back = false;
  if (mixture)
    all.push_back({{{"floor: OURS, Gaussian noise alone"}},
                   [lag_0_alone](const Case& one) { return tracked(gaussian(one.flight.options, one.seed), lag_0_alone); }});
  return all;
}

Case made(double alpha, bool mixture, unsigned seed) {
  FlightOptions options;
  options.alpha = alpha;
  options.mixture = mixture;
  return {flight(options, seed), seed};
}

PaperTable table(const std::string& name, const std::string& what, bool mixture) {
  return table_of<Case>(
      name, what, {"α = 0.1", "α = 0.3", "α = 0.5"},
      [mixture](std::size_t column, unsigned seed) { return made(kAlphas[column], mixture, seed); }, contenders(mixture));
}

/// The largest difference of a position in a run from two back-ends: at lag 0, then 2 s later.
std::vector<Score> back_ends(const Flight& flight, FlightTrackerOptions options) {
  FlightTracker irls(kFlightStep, starts_of(flight), options);
  options.backend = "ceres";
  FlightTracker ceres(kFlightStep, starts_of(flight), options);
  double now = 0, late = 0;
  for (int k = 0; k < flight.options.steps; ++k) {
    for (FlightTracker* tracker : {&irls, &ceres}) tracker->step(samples_of(flight, k));
    for (std::size_t f = 0; f < flight.gps.size(); ++f) {
      now = std::max(now, (irls.state(f).position() - ceres.state(f).position()).norm());
      if (options.looks_back && k >= first_late(options))
        late = std::max(late, (irls.smoothed(f, kLag).position() - ceres.smoothed(f, kLag).position()).norm());
    }
  }
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  if (!options.looks_back) return {{now, kNone}};
  return {{now, kNone}, {late, kNone}};
}

PaperTable back_end_table(const std::string& scenario) {
  PaperTable table = table_of<Case>(
      "ceres and irls", scenario + "The largest difference of a position in a run [m].", {"Table 2, α = 0.1", "mixture, α = 0.5"},
      [](std::size_t column, unsigned seed) { return column == 0 ? made(0.1, false, seed) : made(0.5, true, seed); },
      {{{{"ours, constant velocity"}}, [](const Case& one) { return back_ends(one.flight, straight()); }},
       {{{"OURS, turning"}, {"OURS, turning, 2 s lag"}}, [](const Case& one) { return back_ends(one.flight, {}); }}});
  table.most_runs = 1;
  return table;
}

/// 20 s of one follower in a turn.
Json tracks(unsigned seed) {
  constexpr int kFirst = 3000, kSteps = 625, kEvery = 5;
  const Flight flight = made(0.5, true, seed).flight;
  FlightTracker tracker(kFlightStep, starts_of(flight), {});
  ImmB rival({FilterB::arkf, 8, 0.01}, start_of(flight, 0));
  std::vector<Vector<2>> gps, truth, theirs, ours;
  for (int k = 0; k < kFirst + kSteps; ++k) {
    tracker.step(samples_of(flight, k));
    rival.step(flight.gps[0][k]);
    if (k < kFirst) continue;
    gps.push_back(flight.gps[0][k]);
    truth.push_back(flight.truth[0][k].position());
    theirs.push_back(Motion2(rival.state().mean).position());
    ours.push_back(tracker.state(0).position());
  }
  return {{"measurements", track_of(gps, kEvery)},
          {"IMM-ARKF, R = 8", track_of(theirs, kEvery)},
          {"OURS", track_of(ours, kEvery)},
          {"truth", track_of(truth, kEvery)}};
}

std::vector<PaperTable> tables() {
  const std::string scenario =
      "Two circles of 20 m at 0.4 m/s, 8 followers, 9818 samples of 0.032 s (half a figure of eight, from anywhere on it); RMS of the 2D "
      "error over followers and samples [m], start-up included; µs/step: all eight followers. Rivals: Q = 0.01 I, Π = 0.4/0.3/0.3. OURS: "
      "one setting for all cells: R = 0.7 m², Huber 2.5, a state every 16 samples, q = 2e-6 m²/s³, q_turn = 5e-6 rad²/s³; a sample further "
      "than 3.5 m from its state is flagged, and is an outlier where it is that far from the truth. ";
  std::vector<PaperTable> all{table("Table 2", scenario + "Noise as printed: α t_ν + (1 − α) g, ν ~ U(25, 50).", false),
                              table("A true mixture", scenario + "Noise: t with ν = 3 in a share α of the samples, else N(0, 1).", true)};
  all.back().tracks = tracks;
  if (has_ceres()) all.push_back(back_end_table(scenario));
  return all;
}

}  // namespace

bool bench_paper_b(const RunnerOptions& options, Journal& journal, Terminal& terminal) {
  return run_tables("papers-b", tables(), options, journal, terminal);
}

}  // namespace holdfast::bench
