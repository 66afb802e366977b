#include <holdfast/benchmarks/papers/lifted_table.hpp>
#include <holdfast/benchmarks/papers/missing_map.hpp>
#include <holdfast/benchmarks/papers/network_smoother.hpp>
#include <holdfast/benchmarks/papers/paper.hpp>
#include <holdfast/benchmarks/papers/variance_constrained.hpp>
#include <holdfast/solvers/detail/clock.hpp>
#include <optional>

namespace holdfast::bench {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

enum class Estimator { printed, coupled, free, free_coupled, recursive, ours, ours_coupled, ours_complete };

struct Row {
  std::string name;
  Estimator estimator;
  std::vector<double> paper = {};
  std::optional<Course> course = {};  ///< instead of the column's
};

template <int S>
Score score_of(const Network<S>& network, const Tracks<S>& tracks, double seconds) {
  const NetworkError error = error_of(network, tracks);
  return {error.mean, 1e6 * seconds / static_cast<double>(tracks.size()), {{"RMSE [m]", error.rms}}};
}

template <int S>
Score map_score(const Network<S>& network, MissingMap::Previous previous, Missing missing) {
  const Stopwatch watch;
  const Tracks<S> tracks = missing_map(network, {previous, missing}, "irls");
  return score_of(network, tracks, watch.seconds());
}

template <int S>
Score recursive_score(const Network<S>& network) {
  const Stopwatch watch;
  const Tracks<S> tracks = variance_constrained(network);
  return score_of(network, tracks, watch.seconds());
}

template <int S>
Score our_score(const Network<S>& network, Missing missing) {
  NetworkSmoother recipe;
  recipe.missing = missing;
  const SmoothedNetwork<S> smoothed = smooth(network, recipe);
  Score score = score_of(network, smoothed.tracks, smoothed.seconds);
  if (missing == Missing::coupled || network.options.lost == 0) return score;
  score.consistency(smoothed.anees, S * static_cast<int>(network.steps[0].nodes.size()));
  score.more["learned density of the jerk, its root [m/s^2.5]"] = std::sqrt(smoothed.density);
  score.more["cost 1: exact, all at the centroid"] = smoothed.start.start.cost_centroid;
  score.more["cost 2: of the relaxation"] = smoothed.start.start.relaxed.cost;
  score.more["cost 3: exact, at the relaxation's answer"] = smoothed.start.start.cost;
  score.more["cost 4: exact, refined"] = smoothed.start.refined.cost;
  return score;
}

template <int S>
Score run(const NetworkOptions& options, unsigned seed, Estimator estimator) {
  using Previous = MissingMap::Previous;
  const Network<S> network = make_network<S>(options, seed);
  switch (estimator) {
    case Estimator::printed: {
      Score score = map_score(network, Previous::fixed, Missing::nothing);
      if (const double omega = omega_error(network); omega > 0) score.more["RMSE of Ω [m]"] = omega;
      return score;
    }
    case Estimator::coupled:
      return map_score(network, Previous::fixed, Missing::coupled);
    case Estimator::free:
      return map_score(network, Previous::free, Missing::nothing);
    case Estimator::free_coupled:
      return map_score(network, Previous::free, Missing::coupled);
    case Estimator::recursive:
      return recursive_score(network);
    case Estimator::ours_coupled:
      return our_score(network, Missing::coupled);
    default:
      return our_score(network, Missing::nothing);
  }
}

Score run(NetworkOptions options, unsigned seed, const Row& row) {
  options.course = row.course.value_or(options.course);
  if (row.estimator == Estimator::ours_complete) options.lost = 0;
  return options.course == Course::helix ? run<3>(options, seed, row.estimator) : run<2>(options, seed, row.estimator);
}

NetworkOptions network(Course course, double lost, bool whole_network) {
  NetworkOptions options;
  options.course = course;
  options.lost = lost;
  options.whole_network = whole_network;
  return options;
}

std::string percent(double share) { return std::to_string(std::lround(100 * share)) + " %"; }

/// One run of a column: every estimator makes its own network of it.
struct Case {
  NetworkOptions options;
  unsigned seed;
};

PaperTable table(std::string name, std::string what, const std::vector<NetworkOptions>& columns, const std::vector<Row>& rows) {
  std::vector<std::string> names;
  for (const NetworkOptions& options : columns) names.push_back(to_string(options.course) + (' ' + percent(options.lost)));
  std::vector<Contender<Case>> contenders;
  for (const Row& row : rows)
    contenders.push_back({{{row.name, row.paper}}, [row](const Case& one) { return std::vector{run(one.options, one.seed, row)}; }});
  return table_of<Case>(
      std::move(name), std::move(what), names,
      [columns](std::size_t column, unsigned seed) {
        return Case{columns[column], seed};
      },
      contenders);
}

/// The paper's numbers, and how our estimators do on the same networks.
PaperTable main_table(const std::string& name, const std::string& what, bool whole_network, std::vector<double> map,
                      std::vector<double> recursive) {
  std::vector<NetworkOptions> columns;
  for (const Course course : {Course::linear, Course::spiral})
    for (const double lost : {0.05, 0.5}) columns.push_back(network(course, lost, whole_network));
  for (const Course course : {Course::non_formation, Course::helix}) columns.push_back(network(course, 0.5, whole_network));
  return table(name, what, columns,
               {{"MAP as printed", Estimator::printed, std::move(map)},
                {"variance-constrained", Estimator::recursive, std::move(recursive)},
                {"OURS", Estimator::ours},
                {"floor: OURS, nothing lost", Estimator::ours_complete}});
}

/// Where the prior on a missing distance helps, and where it hurts.
PaperTable prior_table(const std::string& name, const std::string& what, bool whole_network) {
  std::vector<NetworkOptions> columns;
  for (const Course course : {Course::linear, Course::spiral, Course::non_formation, Course::helix})
    columns.push_back(network(course, 0.5, whole_network));
  return table(name, what, columns,
               {{"x(t-1) fixed, no prior (as printed)", Estimator::printed},
                {"x(t-1) fixed, Ω coupled", Estimator::coupled},
                {"random walk, no prior", Estimator::free},
                {"random walk, Ω coupled", Estimator::free_coupled},
                {"OURS (no prior)", Estimator::ours},
                {"ours, Ω coupled", Estimator::ours_coupled}});
}

/// Paper C's figure 11.
PaperTable loss_table(const std::string& what) {
  std::vector<NetworkOptions> columns;
  for (const double lost : {0.0, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5}) columns.push_back(network(Course::linear, lost, true));
  PaperTable made = table("Figure 11", what, columns,
                          {{"linear: MAP as printed", Estimator::printed},
                           {"linear: OURS", Estimator::ours},
                           {"spiral: MAP as printed", Estimator::printed, {}, Course::spiral},
                           {"spiral: OURS", Estimator::ours, {}, Course::spiral},
                           {"non-formation: MAP as printed", Estimator::printed, {}, Course::non_formation},
                           {"non-formation: OURS", Estimator::ours, {}, Course::non_formation}});
  for (std::size_t c = 0; c < columns.size(); ++c) made.columns[c] = percent(columns[c].lost);
  return made;
}

template <int S>
double back_ends_apart(const NetworkOptions& options, unsigned seed, const MissingMap& form) {
  const Network<S> network = make_network<S>(options, seed);
  return largest_difference<S>(missing_map(network, form, "irls"), missing_map(network, form, "ceres"));
}

template <int S>
double back_ends_apart(const NetworkOptions& options, unsigned seed, Missing missing) {
  const Network<S> network = make_network<S>(options, seed);
  NetworkSmoother irls, ceres;
  irls.missing = ceres.missing = missing;
  ceres.backend = "ceres";
  return largest_difference<S>(smooth(network, irls).tracks, smooth(network, ceres).tracks);
}

/// Every estimator that solves, from two back-ends: the largest difference of a position in a run.
PaperTable back_end_table(const std::string& scenario) {
  using Previous = MissingMap::Previous;
  std::vector<NetworkOptions> columns;
  for (const Course course : {Course::linear, Course::spiral, Course::non_formation, Course::helix})
    columns.push_back(network(course, 0.5, true));
  std::vector<Contender<Case>> contenders;
  const auto enter = [&](const char* name, const auto& form) {
    contenders.push_back({{{name}}, [form](const Case& one) {
                            const double apart = one.options.course == Course::helix ? back_ends_apart<3>(one.options, one.seed, form)
                                                                                     : back_ends_apart<2>(one.options, one.seed, form);
                            return std::vector<Score>{{apart, kNone}};
                          }});
  };
  enter("x(t-1) fixed, no prior (as printed)", MissingMap{Previous::fixed, Missing::nothing});
  enter("x(t-1) fixed, Ω coupled", MissingMap{Previous::fixed, Missing::coupled});
  enter("random walk, no prior", MissingMap{Previous::free, Missing::nothing});
  enter("random walk, Ω coupled", MissingMap{Previous::free, Missing::coupled});
  enter("OURS (no prior)", Missing::nothing);
  enter("ours, Ω coupled", Missing::coupled);
  std::vector<std::string> names;
  for (const NetworkOptions& options : columns) names.push_back(to_string(options.course) + std::string(" 50 %"));
  PaperTable made = table_of<Case>(
      "ceres and irls", scenario + "The largest difference of a position in a run [m].", names,
      [columns](std::size_t column, unsigned seed) {
        return Case{columns[column], seed};
      },
      contenders);
  made.most_runs = 5;
  return made;
}

/// The spiral, half of the steps lost: where the first node was thought to be.
Json tracks(unsigned seed) {
  const Network<2> seen = make_network<2>(network(Course::spiral, 0.5, true), seed);
  const Tracks<2> printed = missing_map(seen, {}, "irls"), ours = smooth(seen, {}).tracks;
  std::vector<Vector<2>> truth, theirs, smoothed;
  for (std::size_t k = 0; k < seen.steps.size(); ++k) {
    truth.push_back(seen.steps[k].nodes[0]);
    theirs.push_back(printed[k][0]);
    smoothed.push_back(ours[k][0]);
  }
  return {{"MAP as printed", track_of(theirs, 1)}, {"OURS", track_of(smoothed, 1)}, {"truth", track_of(truth, 1)}};
}

std::vector<PaperTable> tables() {
  const std::string scenario =
      "Nodes among anchors, 50 steps of 1 s, range σ = 0.5 m, bearing κ = 6000; packets lost never twice in a row and not at step 0. MPE: "
      "mean "
      "over steps and nodes of the position's error [m]. ";
  const std::string rivals = "MAP: β = the longest step of a node, ρ = 0.5 m. ";
  const std::string ours =
      "OURS: one setting everywhere: all steps together, exact ranges and bearings, white jerk of a density learned from the packets, from "
      "no initial guess. ANEES of the positions at the middle step. ";
  const std::string whole = "All packets of a step are lost together. ", edges = "Each edge loses its own packets. ";
  std::vector<PaperTable> all{
      main_table("whole network", scenario + whole + rivals + ours, true, {0.311, 1.139, 0.806, 3.107, 1.223, 0}, {20.984, kNone, 49.440}),
      main_table("per edge", scenario + edges + rivals + ours, false, {}, {}),
      prior_table("missing-distance prior, whole network", scenario + whole + rivals, true),
      prior_table("missing-distance prior, per edge", scenario + edges + rivals, false), loss_table(scenario + whole + rivals + ours)};
  all.front().tracks = tracks;
  all.push_back(lifted_table());
  if (has_ceres()) all.push_back(back_end_table(scenario + whole + rivals + ours));
  return all;
}

}  // namespace

bool bench_paper_c(const RunnerOptions& options, Journal& journal, Terminal& terminal) {
  return run_tables("papers-c", tables(), options, journal, terminal);
}

}  // namespace holdfast::bench
