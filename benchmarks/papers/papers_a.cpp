// `holdfast bench papers-a`: Tables I and II of paper A and its two UAVs, reproduced; then our estimators on the same kind of data.
#include <algorithm>
#include <holdfast/benchmarks/papers/cpu_watch.hpp>
#include <holdfast/benchmarks/papers/paper.hpp>
#include <holdfast/benchmarks/papers/rivals_a.hpp>
#include <holdfast/benchmarks/papers/tracked_pursuit.hpp>
#include <map>

namespace holdfast::bench {
namespace {

using Kind = WhiteAcceleration<Motion2>::Kind;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// ---- the columns

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
PursuitOptions of_any_sign(PursuitOptions options) {
  options.random_signs = true;
  return options;
}
PursuitOptions longer(PursuitOptions options) {
  options.steps = 800;
  return options;
}

/// One run of a column.
struct Case {
  Pursuit pursuit;
  unsigned seed;
  int first;  ///< step that is scored

  int steps() const { return static_cast<int>(pursuit.truth.size()); }
};

// ---- the paper's estimators

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

Score timed(const Case& one, const std::function<Positions(const Pursuit&)>& rival) {
  const CpuWatch watch;
  const Positions positions = rival(one.pursuit);
  const double microseconds = 1e6 * watch.seconds() / one.steps();
  return {rmse(one.pursuit, positions, one.first, one.steps()), microseconds};
}

struct Variant {
  const char* name;
  WindowedOptions options;
};
const std::vector<Variant>& variants() {
  static const std::vector<Variant> all{
      {"BLS, trimmed, P", {least_squares_losses()}},
      {"sum of norms, λ = 2", {sum_of_norms_losses(2)}},
      {"sum of norms, λ = 5", {sum_of_norms_losses(5)}},
      {"robust, anchored, GRG'", {robust_losses(), Kind::paper, true}},
      {"robust, anchored, P", {robust_losses(), Kind::recursive, true}},
      {"robust, trimmed, GRG'", {robust_losses(), Kind::paper, false}},
      {"robust, trimmed, P", {robust_losses(), Kind::recursive, false}},
  };
  return all;
}

// ---- ours

TrackerOptions with_loss(const Loss& loss) {
  TrackerOptions options;
  options.loss = loss;
  return options;
}

// ---- the tables

/// What the paper printed; a row without numbers where it has none.
struct Printed {
  std::vector<double> measurement, second_measurement, kalman;
  std::map<std::string, std::vector<double>> variants;  ///< by name
};

std::vector<Contender<Case>> contenders(const Printed& paper, bool two) {
  std::vector<Contender<Case>> all;
  const auto enter = [&](std::vector<PaperRow> rows, std::function<std::vector<Score>(const Case&)> run) {
    all.push_back({std::move(rows), std::move(run)});
  };
  enter({{"measurement", paper.measurement}}, [](const Case& one) { return std::vector{measured(one.pursuit, 0)}; });
  if (two)
    enter({{"measurement, 2nd UAV", paper.second_measurement}}, [](const Case& one) { return std::vector{measured(one.pursuit, 1)}; });
  enter({{"KF", paper.kalman}}, [](const Case& one) { return std::vector{timed(one, kalman_a)}; });
  for (const Variant& variant : variants()) {
    const auto printed = paper.variants.find(variant.name);
    enter({{variant.name, printed == paper.variants.end() ? std::vector<double>() : printed->second}}, [&variant](const Case& one) {
      return std::vector{timed(one, [&](const Pursuit& pursuit) { return windowed_a(pursuit, variant.options); })};
    });
  }
  const auto ours = [&](const std::string& name, const TrackerOptions& options) {
    enter({{name}, {name + ", 1 s lag"}}, [options](const Case& one) { return scored(one.pursuit, one.first, options); });
  };
  ours("OURS, truncated", {});
  ours("ours, Student-t 3", with_loss(StudentT{3}));
  ours("ours, Huber 1.345", with_loss(Huber{1.345}));
  enter({{"floor: OURS without outliers"}, {"floor: the same, 1 s lag"}},
        [](const Case& one) { return scored(without_outliers(one.pursuit.options, one.seed), one.first, {}); });
  return all;
}

PaperTable table(const std::string& name, const std::string& what, const std::vector<Column>& columns, const Printed& paper, int first) {
  std::vector<std::string> names;
  for (const Column& column : columns) names.push_back(column.name);
  const bool two = std::all_of(columns.begin(), columns.end(), [](const Column& column) { return column.options.sensors.size() > 1; });
  return table_of<Case>(
      name, what, names,
      [columns, first](std::size_t c, unsigned seed) {
        return Case{pursuit(columns[c].options, seed), seed, first};
      },
      contenders(paper, two));
}

double largest_difference(const Positions& a, const Positions& b) {
  double largest = 0;
  for (std::size_t k = 0; k < a.size(); ++k) largest = std::max(largest, (a[k] - b[k]).norm());
  return largest;
}

Score windows_apart(const Pursuit& pursuit, WindowedOptions options) {
  const Positions irls = windowed_a(pursuit, options);
  options.backend = "ceres";
  return {largest_difference(irls, windowed_a(pursuit, options)), kNone};
}

std::vector<Score> trackers_apart(const Pursuit& pursuit, TrackerOptions options) {
  const auto by_irls = tracker_of(pursuit, options);
  options.backend = "ceres";
  const auto by_ceres = tracker_of(pursuit, options);
  const Tracked irls = track(*by_irls, pursuit), ceres = track(*by_ceres, pursuit);
  return {{largest_difference(irls.now, ceres.now), kNone}, {largest_difference(irls.late, ceres.late), kNone}};
}

/// Every estimator that solves, from two back-ends: the largest difference of a position in a run.
PaperTable back_end_table(const std::string& scenario) {
  std::vector<Contender<Case>> all;
  for (const Variant& variant : variants())
    all.push_back({{{variant.name}}, [&variant](const Case& one) { return std::vector{windows_apart(one.pursuit, variant.options)}; }});
  const auto ours = [&](const std::string& name, const TrackerOptions& options) {
    all.push_back({{{name}, {name + ", 1 s lag"}}, [options](const Case& one) { return trackers_apart(one.pursuit, options); }});
  };
  ours("OURS, truncated", {});
  ours("ours, Student-t 3", with_loss(StudentT{3}));
  ours("ours, Huber 1.345", with_loss(Huber{1.345}));
  const std::vector<PursuitOptions> columns{with(gentle(), 0.2, 0.2), with(fast(), 0.2, 0.2), with_t(gentle(), 1), with_two(gentle())};
  PaperTable made = table_of<Case>(
      "ceres and irls", scenario + "400 steps; the largest difference of a position in a run [m].",
      {"gentle 20 %, missing 20 %", "fast 20 %, missing 20 %", "gentle, t 1", "two UAVs, gentle"},
      [columns](std::size_t c, unsigned seed) {
        return Case{pursuit(columns[c], seed), seed, 0};
      },
      all);
  made.most_runs = 2;
  return made;
}

/// Gentle, 20 % outliers: where everybody thought the target was.
Json tracks(unsigned seed) {
  const Pursuit seen = pursuit(longer(with(gentle(), 0.2)), seed);
  Positions truth, received;
  for (std::size_t k = 0; k < seen.truth.size(); ++k) {
    truth.push_back(seen.truth[k].position());
    received.push_back(seen.sightings[k][0].z);
  }
  const auto tracker = tracker_of(seen, {});
  return {{"measurements", track_of(received, 5)},
          {"paper's estimator", track_of(windowed_a(seen, {robust_losses()}), 5)},
          {"OURS", track_of(track(*tracker, seen).now, 5)},
          {"truth", track_of(truth, 5)}};
}

const char* const kScenario =
    "Unicycle, turn rate U(-0.5, 0.5) rad/s held 2-6 s, steps of 0.05 s; outliers U(40, 70) m on both axes, always to the same side unless "
    "said otherwise; RMS of the 2D error [m]. Rivals as in paper A: Q = R = P0 = I, window of 15 measured states, a = 2 element by "
    "element. ";
const char* const kOurs =
    "OURS: one setting everywhere: true σ, truncated squares at 3.5 σ, window of 30 measured states and arrival cost, turn 0.1 rad²/s. ";
const char* const kAll = "Fast: σ = 5 m, 20 m/s, 400 steps, all of them scored, start-up included. ";

PaperTable table_1() {
  return table("Table I", std::string(kScenario) + kAll + kOurs,
               {{"1 %", with(fast(), 0.01)},
                {"10 %", with(fast(), 0.1)},
                {"20 %", with(fast(), 0.2)},
                {"t 1", with_t(fast(), 1)},
                {"t 1.5", with_t(fast(), 1.5)}},
               {{10.8188, 25.1747, 35.6328, 29.7823, 11.3826},
                {},
                {8.0046, 15.2958, 22.7106, 18.8719, 7.5597},
                {{"BLS, trimmed, P", {7.8278, 14.9382, 22.2341, 19.0643, 7.3467}},
                 {"sum of norms, λ = 2", {7.0772, 6.4094, 10.4175, 7.4666, 6.0241}},
                 {"robust, anchored, GRG'", {5.3048, 5.5084, 8.0318, 6.2184, 5.7279}}}},
               0);
}

PaperTable table_2() {
  return table("Table II", std::string(kScenario) + kAll + kOurs + "20 % outliers, and missing: ",
               {{"1 % missing", with(fast(), 0.2, 0.01)},
                {"10 % missing", with(fast(), 0.2, 0.1)},
                {"20 % missing", with(fast(), 0.2, 0.2)},
                {"40 % missing", with(fast(), 0.2, 0.4)}},
               {{35.8215, 35.4122, 34.7541, 37.7812},
                {},
                {22.9701, 23.1594, 23.7785, 33.5473},
                {{"BLS, trimmed, P", {22.5718, 22.8851, 25.1728, 31.2794}},
                 {"sum of norms, λ = 2", {10.9128, 10.4728, 15.5712, 19.2022}},
                 {"robust, anchored, GRG'", {8.1266, 8.4694, 8.8115, 10.8259}}}},
               0);
}

PaperTable two_uavs() {
  return table("Two UAVs", std::string(kScenario) + kAll + "20 % outliers of 40-70 m and 10 % of 30-60 m, 20 % missing each.",
               {{"two UAVs", with_two(fast())}}, {{36.7993}, {22.6096}, {}, {{"robust, anchored, GRG'", {6.6577}}}}, 0);
}

PaperTable beyond() {
  PaperTable made = table(
      "Beyond the paper",
      std::string(kScenario) +
          "800 steps, the first 60 not scored. Gentle: σ = 1 m, 10 m/s; fast: σ = 5 m, 20 m/s; t: Student's t, ν = 1, on top of σ = 1 m. " +
          kOurs,
      {{"gentle 20 %", with(longer(gentle()), 0.2)},
       {"and 40 % missing", with(longer(gentle()), 0.2, 0.4)},
       {"fast 20 %", with(longer(fast()), 0.2)},
       {"fast, 40 % missing", with(longer(fast()), 0.2, 0.4)},
       {"two UAVs, gentle", with_two(longer(gentle()))},
       {"gentle, any sign", of_any_sign(with(longer(gentle()), 0.2))},
       {"gentle, t 1", with_t(longer(gentle()), 1)}},
      {}, kStartUp);
  made.tracks = tracks;
  return made;
}

}  // namespace

bool bench_paper_a(const RunnerOptions& options, Journal& journal, Terminal& terminal) {
  std::vector<PaperTable> tables{table_1(), table_2(), two_uavs(), beyond()};
  if (has_ceres()) tables.push_back(back_end_table(kScenario));
  return run_tables("papers-a", tables, options, journal, terminal);
}

}  // namespace holdfast::bench
