// `holdfast bench papers-a`: Tables I and II of paper A and its two UAVs, reproduced; then our estimators on the same kind of data.
#include <Eigen/LU>
#include <algorithm>
#include <holdfast/benchmarks/papers/cpu_watch.hpp>
#include <holdfast/benchmarks/papers/paper.hpp>
#include <holdfast/benchmarks/papers/rivals_a.hpp>
#include <holdfast/benchmarks/papers/robust_tracker.hpp>

namespace holdfast::bench {
namespace {

using Kind = WhiteAcceleration<Motion2>::Kind;

constexpr int kLag = 20;      // steps: 1 s
constexpr int kStartUp = 60;  // steps
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// What a column of a table is.
struct Column {
  std::string name;
  PursuitOptions options;
};

PursuitOptions with(PursuitOptions options, double outliers, double missing = 0) {
  options.sensors[0].outliers = outliers;
  options.sensors[0].missing = missing;
  return options;
}
PursuitOptions with_t(PursuitOptions options, double nu) {
  options.sensors[0].student_nu = nu;
  return options;
}
/// 20 % outliers of 40-70 m seen by the first, 10 % of 30-60 m by the second, 20 % missing each.
PursuitOptions with_two(PursuitOptions options) {
  options = with(options, 0.2, 0.2);
  options.sensors.push_back({0.1, 30, 60, 0.2, 0});
  return options;
}

/// RMS of what one camera received.
Score measured(const Pursuit& pursuit, std::size_t camera) {
  double sum = 0;
  int count = 0;
  for (std::size_t k = 0; k < pursuit.truth.size(); ++k) {
    const Sighting& sighting = pursuit.sightings[k][camera];
    if (!sighting.received) continue;
    sum += (sighting.z - pursuit.truth[k].position()).squaredNorm();
    ++count;
  }
  return {std::sqrt(sum / count), kNone};
}

/// Of a rival, which is run from the first step to the last.
template <class Estimator>
Score timed(const Pursuit& pursuit, int first, const Estimator& estimator) {
  const CpuWatch watch;
  const Positions positions = estimator(pursuit);
  const double seconds = watch.seconds();
  const int steps = static_cast<int>(pursuit.truth.size());
  return {rmse(pursuit, positions, first, steps), 1e6 * seconds / steps};
}

std::vector<Matrix<2, 2>> true_covariances(const Pursuit& pursuit) {
  const double variance = pursuit.options.sigma * pursuit.options.sigma;
  return std::vector<Matrix<2, 2>>(pursuit.options.sensors.size(), variance * Matrix<2, 2>::Identity());
}

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

/// Ours at lag 0, then at a lag of 1 s.
std::vector<Score> tracked(const Pursuit& pursuit, int first, const TrackerOptions& options) {
  constexpr int kSample = 50;  // steps between two errors that hardly know of each other
  const int steps = static_cast<int>(pursuit.truth.size());
  RobustTracker tracker(pursuit.options.dt, true_covariances(pursuit), options);
  Positions now, late;
  double microseconds = 0, nees = 0;
  int samples = 0;
  for (int k = 0; k < steps; ++k) {
    const CpuWatch watch;
    tracker.step(pursuit.sightings[k]);
    now.push_back(tracker.state().position());
    if (k >= kLag) late.push_back(tracker.smoothed(kLag).position());
    microseconds += 1e6 * watch.seconds() / steps;
    if (k < kStartUp || k % kSample != 0) continue;
    const Vector<4> error = tracker.state().value - pursuit.truth[k].value;
    nees += error.dot(tracker.covariance().inverse() * error) / 4;
    ++samples;
  }
  Score lag_0{rmse(pursuit, now, first, steps), microseconds}, lag_1{rmse(pursuit, late, first, steps - kLag), microseconds};
  lag_0.more["anees"] = nees / samples;
  lag_0.more["second half"] = rmse(pursuit, now, steps / 2, steps);
  lag_0.more["re-acquisitions"] = tracker.reacquisitions();
  judge(pursuit, tracker, lag_0.more);
  return {lag_0, lag_1};
}

/// What the paper printed; a row without numbers where it has none.
struct Printed {
  std::vector<double> measurement, second_measurement, kalman, least_squares, sum_of_norms, robust;
};

TrackerOptions with_loss(const Loss& loss) {
  TrackerOptions options;
  options.loss = loss;
  return options;
}

PaperTable table(const std::string& name, const std::string& what, const std::vector<Column>& columns, const Printed& paper, int first) {
  struct Variant {
    const char* name;
    std::vector<double> paper;
    WindowedOptions options;
  };
  const std::vector<Variant> variants{
      {"BLS, trimmed, P", paper.least_squares, {least_squares_losses()}},
      {"sum of norms, λ = 2", paper.sum_of_norms, {sum_of_norms_losses(2)}},
      {"sum of norms, λ = 5", {}, {sum_of_norms_losses(5)}},
      {"robust, anchored, GRG'", paper.robust, {robust_losses(), Kind::paper, true}},
      {"robust, anchored, P", {}, {robust_losses(), Kind::recursive, true}},
      {"robust, trimmed, GRG'", {}, {robust_losses(), Kind::paper, false}},
      {"robust, trimmed, P", {}, {robust_losses(), Kind::recursive, false}},
  };
  PaperTable made{name, what, {}, {{"measurement", paper.measurement}, {"measurement, 2nd UAV", paper.second_measurement}}, {}};
  for (const Column& column : columns) made.columns.push_back(column.name);
  made.rows.push_back({"KF", paper.kalman});
  for (const Variant& variant : variants) made.rows.push_back({variant.name, variant.paper});
  for (const char* ours : {"OURS, truncated", "OURS, truncated, 1 s lag", "ours, Student-t 3", "ours, Student-t 3, 1 s lag",
                           "ours, Huber 1.345", "ours, Huber 1.345, 1 s lag", "floor: OURS without outliers", "floor: the same, 1 s lag"})
    made.rows.push_back({ours});
  const bool two = std::all_of(columns.begin(), columns.end(), [](const Column& column) { return column.options.sensors.size() > 1; });
  if (!two) made.rows.erase(made.rows.begin() + 1);

  made.run = [columns, variants, first, two](std::size_t column, unsigned seed) {
    const Pursuit pursuit = bench::pursuit(columns[column].options, seed);
    std::vector<Score> scores{measured(pursuit, 0)};
    if (two) scores.push_back(measured(pursuit, 1));
    scores.push_back(timed(pursuit, first, kalman_a));
    for (const Variant& variant : variants)
      scores.push_back(timed(pursuit, first, [&](const Pursuit& p) { return windowed_a(p, variant.options); }));
    const auto add = [&](const std::vector<Score>& more) { scores.insert(scores.end(), more.begin(), more.end()); };
    add(tracked(pursuit, first, {}));
    add(tracked(pursuit, first, with_loss(StudentT{3})));
    add(tracked(pursuit, first, with_loss(Huber{1.345})));
    add(tracked(without_outliers(columns[column].options, seed), first, {}));
    return scores;
  };
  return made;
}

std::vector<PaperTable> tables() {
  const std::string scenario =
      "Unicycle, turn rate U(-0.5, 0.5) rad/s held 2-6 s, steps of 0.05 s; outliers U(40, 70) m on both axes, always to the same side "
      "unless said "
      "otherwise; RMS of the 2D error [m]. Rivals as in paper A: Q = R = P0 = I, window of 15 measured states, a = 2 element by element. ";
  const std::string ours =
      "OURS: one setting everywhere: true σ, truncated squares at 3.5 σ, window of 30 measured states and arrival cost, turn 0.1 rad²/s. "
      "ANEES of a "
      "consistent estimator over R runs: 1 ± 0.37/√R in 95 %. ";
  const std::string all = "Fast: σ = 5 m, 20 m/s, 400 steps, all of them scored, start-up included. ";
  PursuitOptions long_gentle = gentle(), long_fast = fast();
  long_gentle.steps = long_fast.steps = 800;
  PursuitOptions random_signs = with(long_gentle, 0.2);
  random_signs.random_signs = true;
  return {
      table("Table I", scenario + all + ours,
            {{"1 %", with(fast(), 0.01)},
             {"10 %", with(fast(), 0.1)},
             {"20 %", with(fast(), 0.2)},
             {"t 1", with_t(fast(), 1)},
             {"t 1.5", with_t(fast(), 1.5)}},
            {{10.8188, 25.1747, 35.6328, 29.7823, 11.3826},
             {},
             {8.0046, 15.2958, 22.7106, 18.8719, 7.5597},
             {7.8278, 14.9382, 22.2341, 19.0643, 7.3467},
             {7.0772, 6.4094, 10.4175, 7.4666, 6.0241},
             {5.3048, 5.5084, 8.0318, 6.2184, 5.7279}},
            0),
      table("Table II", scenario + all + "20 % outliers, and missing: ",
            {{"1 % missing", with(fast(), 0.2, 0.01)},
             {"10 % missing", with(fast(), 0.2, 0.1)},
             {"20 % missing", with(fast(), 0.2, 0.2)},
             {"40 % missing", with(fast(), 0.2, 0.4)}},
            {{35.8215, 35.4122, 34.7541, 37.7812},
             {},
             {22.9701, 23.1594, 23.7785, 33.5473},
             {22.5718, 22.8851, 25.1728, 31.2794},
             {10.9128, 10.4728, 15.5712, 19.2022},
             {8.1266, 8.4694, 8.8115, 10.8259}},
            0),
      table("Two UAVs", scenario + all + "20 % outliers of 40-70 m and 10 % of 30-60 m, 20 % missing each.",
            {{"two UAVs", with_two(fast())}}, {{36.7993}, {22.6096}, {}, {}, {}, {6.6577}}, 0),
      table("Beyond the paper",
            scenario +
                "800 steps, the first 60 not scored. Gentle: σ = 1 m, 10 m/s; fast: σ = 5 m, 20 m/s; t: Student's t, ν = 1, on top of σ = "
                "1 m. " +
                ours,
            {{"gentle 20 %", with(long_gentle, 0.2)},
             {"and 40 % missing", with(long_gentle, 0.2, 0.4)},
             {"fast 20 %", with(long_fast, 0.2)},
             {"two UAVs, gentle", with_two(long_gentle)},
             {"gentle, any sign", random_signs},
             {"gentle, t 1", with_t(long_gentle, 1)}},
            {}, kStartUp),
  };
}

}  // namespace

bool bench_paper_a(const RunnerOptions& options, Journal& journal, Terminal& terminal) {
  return run_tables("papers-a", tables(), options, journal, terminal);
}

}  // namespace holdfast::bench
