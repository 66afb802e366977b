#include <algorithm>
#include <filesystem>
#include <holdfast/adapters/files/to_dataset.hpp>
#include <holdfast/benchmarks/race.hpp>
#include <holdfast/benchmarks/suites/profile.hpp>
#include <holdfast/benchmarks/suites/robust_cases.hpp>
#include <holdfast/common/machine.hpp>
#include <holdfast/common/metrics.hpp>
#include <holdfast/common/table.hpp>
#include <holdfast/graph/files/atomic.hpp>
#include <holdfast/graph/files/files.hpp>
#include <holdfast/solvers/chi_square.hpp>
#include <holdfast/solvers/irls/irls.hpp>
#include <holdfast/solvers/outlier_report.hpp>
#include <holdfast/solvers/pairwise_consistency.hpp>
#include <holdfast/solvers/range_consistency.hpp>
#include <holdfast/solvers/table.hpp>
#include <map>

namespace holdfast::bench {
namespace {

constexpr double kAlpha = 0.01;      // of a threshold
constexpr double kSuccess = 0.1;     // [m] from the optimum without false loops
constexpr double kOfTheClean = 2;    // of ranges: times the error of the clean problem's optimum
constexpr unsigned kUsualRuns = 10;  // seeds

/// One squared solve of the problem without what was added to it, from the same start: what robustness costs is compared with it.
double clean_seconds(const AttackedGraph& problem, const Options& options) {
  Graph clean = problem.graph;
  for (const FactorId id : problem.false_loops) clean.remove(id);
  std::vector<double> seconds;
  for (int i = 0; i < 3; ++i) {
    Values x = problem.start;
    const Stopwatch watch;
    Irls(options).solve(clean, x);
    seconds.push_back(watch.seconds());
  }
  return median(seconds);
}

Json ratio(long part, long whole) { return whole > 0 ? Json(static_cast<double>(part) / static_cast<double>(whole)) : Json(nullptr); }

/// What does not agree with the others, of loops or of ranges.
std::vector<FactorId> inconsistent(const Graph& graph, const AttackedGraph& problem) {
  if (problem.truth.size() > 0) return consistent_ranges(graph).rejected;
  PairwiseConsistencyOptions pcm;
  pcm.odometry = problem.odometry;
  return consistent_loops(graph, pcm).rejected;
}

Json scored(const RobustMethod& method, const AttackedGraph& problem, bool is_labelled, const Options& options) {
  const Stopwatch watch;
  Graph graph = problem.graph;
  for (const auto* loops : {&problem.true_loops, &problem.false_loops})
    for (const FactorId id : *loops) {
      const Graph::Place& place = graph.place(id);
      graph.set_loss(id, method.loss(std::sqrt(chi_square_quantile(1 - kAlpha, graph.batches()[place.batch]->residual_dim()))));
    }
  if (method.pcm)
    for (const FactorId id : inconsistent(graph, problem)) graph.remove(id);
  Values answer = problem.start;
  const Summary summary = make_backend(method.backend, options)->solve(graph, answer);
  Json line;
  line["seconds"] = watch.seconds();
  line["termination"] = to_string(summary.termination);
  const bool of_ranges = problem.truth.size() > 0;
  const auto error = position_error(of_ranges ? problem.truth : problem.clean, answer);
  const bool has_ended = summary.usable() && error;
  line["ate"] = has_ended ? Json(error->ate_rmse) : Json(nullptr);
  double good_enough = kSuccess;
  if (of_ranges) {
    const double clean = position_error(problem.truth, problem.clean)->ate_rmse;
    line["ate_clean"] = is_labelled ? Json(clean) : Json(nullptr);
    good_enough = std::max(kSuccess, kOfTheClean * clean);
  }
  // Where nobody knows which ranges of a file are false, nobody knows what a success is.
  line["success"] = is_labelled ? Json(has_ended && error->ate_rmse < good_enough) : Json(nullptr);
  const auto believed = [&](FactorId id) {
    if (!graph.contains(id)) return false;
    const Graph::Place& place = graph.place(id);
    const Eigen::VectorXd r = graph.residual(id, answer);
    return !is_rejected(relative_weight(graph.batches()[place.batch]->loss(place.index), r.data(), static_cast<int>(r.size())));
  };
  const long true_kept = std::count_if(problem.true_loops.begin(), problem.true_loops.end(), believed);
  const long false_kept = std::count_if(problem.false_loops.begin(), problem.false_loops.end(), believed);
  line["true_lost"] = static_cast<long>(problem.true_loops.size()) - true_kept;
  line["false_kept"] = false_kept;
  line["true_loops"] = problem.true_loops.size();
  line["false_loops"] = problem.false_loops.size();
  line["precision"] = is_labelled ? ratio(true_kept, true_kept + false_kept) : Json(nullptr);
  line["recall"] = is_labelled ? ratio(true_kept, static_cast<long>(problem.true_loops.size())) : Json(nullptr);
  return line;
}

bool same_run(const Json& a, const Json& b) {
  for (const char* field : {"graph", "kind", "share", "seed", "method", "commit", "machine", "time_limit", "tolerance", "threads"})
    if (a.value(field, Json()) != b.value(field, Json())) return false;
  return true;
}

/// The problem with its start as vertices, its clean optimum, and how to tell its false loops: the last of its edges.
void write_problem(const std::string& directory, const RobustSetting& setting, unsigned seed, const AttackedGraph& problem) {
  namespace fs = std::filesystem;
  fs::create_directories(directory);
  std::string name = std::string(setting.graph) + '_' + setting.kind() + '_' + cell("%g", setting.share()) + '_' + std::to_string(seed);
  std::replace(name.begin(), name.end(), ' ', '-');
  const std::string path = (fs::path(directory) / name).string();
  write_g2o(path + ".g2o", to_dataset(problem.graph, problem.start, Format::G2o));
  write_g2o(path + "_clean.g2o", to_dataset(problem.graph, problem.clean, Format::G2o));
  const Json about{{"graph", setting.graph},
                   {"kind", setting.kind()},
                   {"share", setting.share()},
                   {"seed", seed},
                   {"alpha", kAlpha},
                   {"true_loops", problem.true_loops.size()},
                   {"false_loops", problem.false_loops.size()},
                   {"commit", commit()}};
  atomic_write(path + ".json", about.dump() + '\n');
}

/// Of the lines of one method on one kind of problem.
struct Scores {
  int good = 0, judged = 0;
  std::vector<double> ate, seconds, times_clean, precision, recall;

  void add(const Json& line) {
    const auto number = [&](const char* field, double otherwise) {
      return line[field].is_number() ? line[field].get<double>() : otherwise;
    };
    ate.push_back(number("ate", std::numeric_limits<double>::infinity()));
    judged += line["success"].is_boolean();
    good += line["success"] == true;
    seconds.push_back(line["seconds"]);
    times_clean.push_back(seconds.back() / number("clean_seconds", NAN));
    if (line["precision"].is_number()) precision.push_back(line["precision"]);
    if (line["recall"].is_number()) recall.push_back(line["recall"]);
  }
};

std::string median_cell(const char* format, const std::vector<double>& numbers) {
  return numbers.empty() ? "-" : cell(format, median(numbers));
}

void print_scores(std::ostream& out, const std::vector<Json>& lines) {
  constexpr auto left = Table::Align::left, right = Table::Align::right;
  Table table({{"graph", left},
               {"outliers", left},
               {"share", right},
               {"method", left},
               {"success", right},
               {"ATE median [m]", right},
               {"worst", right},
               {"precision", right},
               {"recall", right},
               {"s, median", right},
               {"x clean", right}});
  const auto same = [](const Json& a, const Json& b) {
    return a["graph"] == b["graph"] && a["kind"] == b["kind"] && a["share"] == b["share"] && a["method"] == b["method"];
  };
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (std::any_of(lines.begin(), lines.begin() + static_cast<std::ptrdiff_t>(i), [&](const Json& l) { return same(l, lines[i]); }))
      continue;
    Scores scores;
    for (const Json& line : lines)
      if (same(line, lines[i])) scores.add(line);
    table.add({lines[i]["graph"], lines[i]["kind"], cell("%g", lines[i]["share"]), lines[i]["method"],
               scores.judged > 0 ? std::to_string(scores.good) + "/" + std::to_string(scores.judged) : "-", median_cell("%.4f", scores.ate),
               cell("%.3f", *std::max_element(scores.ate.begin(), scores.ate.end())), median_cell("%.3f", scores.precision),
               median_cell("%.3f", scores.recall), median_cell("%.3f", scores.seconds), median_cell("%.1f", scores.times_clean)});
  }
  table.print(out);
}

/// Profiles over the runs that every method has and where success can be judged: seconds, a failure is infinite; and how near the answers
/// are. Errors are not compared by their ratio: many are zero to rounding.
void print_profiles(std::ostream& out, const std::vector<Json>& lines) {
  const std::vector<double> factors{1, 2, 5, 10, 100}, errors{0.001, 0.01, 0.1, 1};
  std::vector<std::string> methods;
  std::map<std::string, std::map<std::string, const Json*>> runs;
  for (const Json& line : lines) {
    const std::string method = line["method"];
    if (std::find(methods.begin(), methods.end(), method) == methods.end()) methods.push_back(method);
    if (line["success"].is_boolean()) runs[Json{line["graph"], line["kind"], line["share"], line["seed"]}.dump()][method] = &line;
  }
  constexpr double kFailed = std::numeric_limits<double>::infinity();
  std::vector<std::vector<double>> seconds, ate;
  for (const auto& [problem, of_method] : runs) {
    if (of_method.size() < methods.size()) continue;
    seconds.emplace_back();
    ate.emplace_back();
    for (const std::string& method : methods) {
      const Json& line = *of_method.at(method);
      seconds.back().push_back(line["success"] == true ? line["seconds"].get<double>() : kFailed);
      ate.back().push_back(line["ate"].is_number() ? line["ate"].get<double>() : kFailed);
    }
  }
  if (methods.size() < 2 || seconds.empty()) return;
  std::vector<Table::Column> columns{{"share of " + std::to_string(seconds.size()) + " runs", Table::Align::left}};
  for (const double factor : factors) columns.push_back({cell("%g x fastest", factor), Table::Align::right});
  for (const double error : errors) columns.push_back({cell("ATE <= %g m", error), Table::Align::right});
  Table table(columns);
  const auto profile = performance_profile(seconds, factors);
  for (std::size_t m = 0; m < methods.size(); ++m) {
    std::vector<std::string> row{methods[m]};
    for (const double share : profile[m]) row.push_back(cell("%.3f", share));
    for (const double error : errors) {
      const auto near = std::count_if(ate.begin(), ate.end(), [&](const auto& problem) { return problem[m] <= error; });
      row.push_back(cell("%.3f", static_cast<double>(near) / static_cast<double>(ate.size())));
    }
    table.add(row);
  }
  out << "Profiles: solved within so many times the seconds of the fastest that succeeded (a failure never is), and within these errors:\n";
  table.print(out);
}

}  // namespace

bool race_robust(const RunnerOptions& asked, Journal& journal, Terminal& terminal) {
  const Suite suite = suites_of({"robust"}).front();
  Options options = asked.solver;
  options.max_iterations = suite.max_iterations;
  const unsigned runs = asked.runs_are_asked ? asked.runs : kUsualRuns;
  const std::vector<RobustSetting> all = robust_settings(asked);
  const std::vector<RobustMethod> contenders = robust_methods(asked);
  print_head(
      terminal.out, suite,
      "Outliers added to public graphs, start from the odometry, losses on loops or ranges alone, thresholds of a false alarm of 1 %. "
      "Success: of loops within 0.1 m of the optimum without false ones (ATE); of ranges, ATE to the truth below twice that of the "
      "optimum without false ones. pcm: consistent_loops or consistent_ranges first. " +
          std::to_string(runs) + " seeds from " + std::to_string(asked.seed) +
          "; seconds: filter, set-up and solve; x clean: over one squared solve without what was added.");
  ProgressBar bar(terminal, all.size() * runs * contenders.size());
  std::vector<Json> lines;
  std::string absent;
  for (const RobustSetting& setting : all)
    for (unsigned seed = asked.seed; seed < asked.seed + runs; ++seed) {
      std::optional<AttackedGraph> problem;
      const auto make = [&] {
        if (!problem) problem = setting.make(seed);
        return problem.has_value();
      };
      double clean = 0;
      if (!asked.write_to.empty() && !setting.of_ranges() && make()) write_problem(asked.write_to, setting, seed, *problem);
      for (const RobustMethod& method : contenders) {
        if (!setting.takes(method)) continue;
        Json line{{"suite", "robust"},
                  {"graph", setting.graph},
                  {"kind", setting.kind()},
                  {"share", setting.share()},
                  {"seed", seed},
                  {"method", method.name},
                  {"tolerance", options.cost_tolerance},
                  {"threads", options.threads},
                  {"time_limit", options.time_limit},
                  {"commit", commit()},
                  {"machine", machine()}};
        bar.begin(std::string(setting.graph) + " " + method.name);
        const auto& known = journal.lines();
        const auto found = std::find_if(known.begin(), known.end(), [&](const Json& one) { return same_run(one, line); });
        if (!asked.fresh && found != known.end()) {
          lines.push_back(*found);
        } else if (make()) {
          if (clean == 0) clean = clean_seconds(*problem, options);
          line["clean_seconds"] = clean;
          line.update(scored(method, *problem, setting.kind() != to_string(FalseRanges::Kind::as_it_is), options));
          journal.append({line});
          lines.push_back(line);
        } else {
          if (absent.find(setting.graph) == std::string::npos) absent += std::string(" ") + setting.graph;
          break;
        }
        bar.done_with_one();
      }
    }
  bar.clear();
  if (!lines.empty()) {
    print_scores(terminal.out, lines);
    print_profiles(terminal.out, lines);
  }
  if (!absent.empty()) terminal.out << "skipped, for there is no such file in the data directory:" << absent << "\n";
  terminal.out << "results: " << journal.path() << "\n" << std::endl;
  return true;
}

}  // namespace holdfast::bench
