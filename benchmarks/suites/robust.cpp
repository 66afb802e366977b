#include <algorithm>
#include <holdfast/benchmarks/race.hpp>
#include <holdfast/benchmarks/suites/false_loops.hpp>
#include <holdfast/common/machine.hpp>
#include <holdfast/common/metrics.hpp>
#include <holdfast/common/table.hpp>
#include <holdfast/solvers/chi_square.hpp>
#include <holdfast/solvers/outlier_report.hpp>
#include <holdfast/solvers/pairwise_consistency.hpp>
#include <holdfast/solvers/table.hpp>

namespace holdfast::bench {
namespace {

constexpr double kAlpha = 0.01;   // of a threshold
constexpr double kSuccess = 0.1;  // [m] from the optimum without false loops
constexpr unsigned kMostRuns = 10;

struct Method {
  std::string name, backend;
  Loss (*loss)(double c);
  bool pcm;
};

std::vector<Method> methods() {
  const auto squared = [](double) { return Loss(Squared{}); };
  const auto truncated = [](double c) { return Loss(TruncatedSquares{c}); };
  std::vector<Method> all{{"squared", "irls", squared, false},
                          {"huber", "irls", [](double) { return Loss(Huber{1.345}); }, false},
                          {"cauchy", "irls", [](double) { return Loss(Cauchy{1}); }, false},
                          {"geman_mcclure", "irls", [](double c) { return Loss(GemanMcClure{c}); }, false},
                          {"truncated_squares", "irls", truncated, false},
                          {"gnc-irls", "gnc-irls", truncated, false}};
  const std::vector<std::string> names = backend_names();
  if (std::count(names.begin(), names.end(), "ceres") != 0) all.push_back({"gnc-ceres", "gnc-ceres", truncated, false});
  all.push_back({"pcm + squared", "irls", squared, true});
  all.push_back({"pcm + gnc-irls", "gnc-irls", truncated, true});
  return all;
}

struct Setting {
  const char* graph;
  FalseLoops attack;
};

std::vector<Setting> settings() {
  using Kind = FalseLoops::Kind;
  std::vector<Setting> all;
  for (const char* graph : {"CSAIL", "intel", "MIT", "M3500"}) {
    for (const Kind kind : {Kind::random, Kind::at_one_place})
      for (const double share : {0.1, 0.5, 1.0, 3.0}) all.push_back({graph, {kind, share}});
    for (const Kind kind : {Kind::local, Kind::grouped})
      for (const double share : {0.1, 0.5}) all.push_back({graph, {kind, share}});
  }
  for (const char* graph : {"smallGrid3D", "sphere2500"})
    for (const Kind kind : {Kind::random, Kind::near_truth})
      for (const double share : {0.1, 0.5, 1.0}) all.push_back({graph, {kind, share}});
  return all;
}

Json scored(const Method& method, const AttackedGraph& problem, const Options& options) {
  const Stopwatch watch;
  Graph graph = problem.graph;
  for (const auto* loops : {&problem.true_loops, &problem.false_loops})
    for (const FactorId id : *loops) {
      const Graph::Place& place = graph.place(id);
      graph.set_loss(id, method.loss(std::sqrt(chi_square_quantile(1 - kAlpha, graph.batches()[place.batch]->residual_dim()))));
    }
  if (method.pcm) {
    PairwiseConsistencyOptions pcm;
    pcm.odometry = problem.odometry;
    for (const FactorId id : consistent_loops(graph, pcm).rejected) graph.remove(id);
  }
  Values answer = problem.start;
  const Summary summary = make_backend(method.backend, options)->solve(graph, answer);
  Json line;
  line["seconds"] = watch.seconds();
  line["termination"] = to_string(summary.termination);
  const auto error = position_error(problem.clean, answer);
  line["ate"] = summary.usable() && error ? Json(error->ate_rmse) : Json(nullptr);
  const auto believed = [&](FactorId id) {
    if (!graph.contains(id)) return false;
    const Graph::Place& place = graph.place(id);
    const Eigen::VectorXd r = graph.residual(id, answer);
    return !is_rejected(relative_weight(graph.batches()[place.batch]->loss(place.index), r.data(), static_cast<int>(r.size())));
  };
  line["true_lost"] = problem.true_loops.size() - std::count_if(problem.true_loops.begin(), problem.true_loops.end(), believed);
  line["false_kept"] = std::count_if(problem.false_loops.begin(), problem.false_loops.end(), believed);
  line["true_loops"] = problem.true_loops.size();
  line["false_loops"] = problem.false_loops.size();
  return line;
}

bool same_run(const Json& a, const Json& b) {
  for (const char* field : {"graph", "kind", "share", "seed", "method", "commit", "machine", "time_limit"})
    if (a.value(field, Json()) != b.value(field, Json())) return false;
  return true;
}

void print_scores(std::ostream& out, const std::vector<Json>& lines) {
  constexpr auto left = Table::Align::left, right = Table::Align::right;
  Table table({{"graph", left},
               {"false loops", left},
               {"of true", right},
               {"method", left},
               {"success", right},
               {"ATE median [m]", right},
               {"worst", right},
               {"true lost", right},
               {"false kept", right},
               {"s, median", right}});
  const auto same = [](const Json& a, const Json& b) {
    return a["graph"] == b["graph"] && a["kind"] == b["kind"] && a["share"] == b["share"] && a["method"] == b["method"];
  };
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (std::any_of(lines.begin(), lines.begin() + static_cast<std::ptrdiff_t>(i), [&](const Json& l) { return same(l, lines[i]); }))
      continue;
    std::vector<double> ate, seconds, lost, kept;
    int good = 0;
    for (const Json& line : lines) {
      if (!same(line, lines[i])) continue;
      ate.push_back(line["ate"].is_number() ? line["ate"].get<double>() : std::numeric_limits<double>::infinity());
      good += ate.back() < kSuccess;
      seconds.push_back(line["seconds"]);
      lost.push_back(line["true_lost"]);
      kept.push_back(line["false_kept"]);
    }
    table.add({lines[i]["graph"], lines[i]["kind"], cell("%g", lines[i]["share"]), lines[i]["method"],
               std::to_string(good) + "/" + std::to_string(ate.size()), cell("%.4f", median(ate)),
               cell("%.3f", *std::max_element(ate.begin(), ate.end())), cell("%.0f", median(lost)), cell("%.0f", median(kept)),
               cell("%.3f", median(seconds))});
  }
  table.print(out);
}

}  // namespace

bool race_robust(const RunnerOptions& asked, Journal& journal, Terminal& terminal) {
  const Suite suite = suites_of({"robust"}).front();
  Options options = asked.solver;
  options.max_iterations = suite.max_iterations;
  const unsigned runs = std::min(asked.runs, kMostRuns);
  print_head(terminal.out, suite,
             "False loops added to public pose graphs, start from the odometry, losses on loops alone, thresholds of a false alarm of 1 %; "
             "success: within 0.1 m of the optimum without false loops (ATE); " +
                 std::to_string(runs) + " seeds from " + std::to_string(asked.seed) + "; seconds: filter, set-up and solve.");
  const std::vector<Setting> all = settings();
  const std::vector<Method> contenders = methods();
  ProgressBar bar(terminal, all.size() * runs * contenders.size());
  std::vector<Json> lines;
  std::string absent;
  for (const Setting& setting : all)
    for (unsigned seed = asked.seed; seed < asked.seed + runs; ++seed) {
      std::optional<AttackedGraph> problem;
      for (const Method& method : contenders) {
        Json line{
            {"suite", "robust"},   {"graph", setting.graph}, {"kind", to_string(setting.attack.kind)}, {"share", setting.attack.share},
            {"seed", seed},        {"method", method.name},  {"time_limit", options.time_limit},       {"commit", commit()},
            {"machine", machine()}};
        bar.begin(std::string(setting.graph) + " " + method.name);
        const auto& known = journal.lines();
        const auto found = std::find_if(known.begin(), known.end(), [&](const Json& one) { return same_run(one, line); });
        if (!asked.fresh && found != known.end()) {
          lines.push_back(*found);
        } else {
          if (!problem) problem = attacked(setting.graph, setting.attack, seed);
          if (!problem) {
            if (absent.find(setting.graph) == std::string::npos) absent += std::string(" ") + setting.graph;
            break;
          }
          line.update(scored(method, *problem, options));
          journal.append({line});
          lines.push_back(line);
        }
        bar.done_with_one();
      }
    }
  bar.clear();
  print_scores(terminal.out, lines);
  if (!absent.empty()) terminal.out << "skipped, for there is no such file in the data directory:" << absent << "\n";
  terminal.out << "results: " << journal.path() << "\n" << std::endl;
  return true;
}

}  // namespace holdfast::bench
