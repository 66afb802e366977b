#include <sys/resource.h>

#include <algorithm>
#include <holdfast/benchmarks/race.hpp>
#include <holdfast/benchmarks/scenarios/scenario.hpp>
#include <holdfast/benchmarks/suites/fista.hpp>
#include <holdfast/common/machine.hpp>
#include <holdfast/common/table.hpp>
#include <holdfast/solvers/table.hpp>

namespace holdfast::bench {
namespace {

constexpr double kLongest = 180;  // seconds that a million nodes may take
constexpr double kGaps[] = {1e-4, 1e-6};

struct Rival {
  const char* name;
  int most_nodes;  ///< larger networks take it minutes
};
constexpr Rival kRivals[] = {{"irls", 1000000}, {"nesterov", 10000}, {"fista", 10000}, {"ceres", 1000}};

std::unique_ptr<Backend> made(const std::string& name, const Options& options) {
  if (name == "fista") return std::make_unique<Fista>(options);
  return make_backend(name, options);
}

/// Seconds until the cost is within gap · best of the best; NaN where it never is.
double seconds_to(const Summary& summary, double best, double gap) {
  for (const Iteration& iteration : summary.trace)
    if (iteration.cost <= best + gap * std::abs(best)) return iteration.seconds;
  return std::numeric_limits<double>::quiet_NaN();
}

/// The most memory this process has held [GB].
double peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) * 1024 / 1e9;
}

struct Entry {
  std::string name;
  Summary summary;
  std::vector<double> to[2];  ///< seconds to each gap, of each repetition
};

/// Every rival on one network, in turn, `repetitions` times.
std::vector<Entry> solve_network(const Instance& instance, int nodes, const RunnerOptions& options, ProgressBar& bar) {
  std::vector<Entry> entries;
  const std::vector<std::string> known = backend_names();
  for (const Rival& rival : kRivals)
    if (nodes <= rival.most_nodes &&
        (std::string(rival.name) == "fista" || std::find(known.begin(), known.end(), rival.name) != known.end()))
      entries.push_back({rival.name, {}, {}});
  Options solver = options.solver;
  solver.threads = 1;
  solver.time_limit = std::max(solver.time_limit, kLongest);
  solver.trace = true;
  solver.cost_tolerance = 1e-10;
  solver.max_iterations = 10000;
  double best = std::numeric_limits<double>::infinity();
  std::vector<std::vector<Summary>> runs(entries.size());
  const int repetitions = nodes >= 100000 ? 1 : std::max(1, options.repetitions);
  for (int repetition = 0; repetition < repetitions; ++repetition)
    for (std::size_t e = 0; e < entries.size(); ++e) {
      bar.begin("network of " + std::to_string(nodes) + ", " + entries[e].name);
      Values answer = instance.start;
      runs[e].push_back(made(entries[e].name, solver)->solve(instance.graph, answer));
      if (runs[e].back().usable()) best = std::min(best, runs[e].back().cost);
    }
  for (std::size_t e = 0; e < entries.size(); ++e) {
    entries[e].summary = runs[e].front();
    for (const Summary& run : runs[e])
      for (int g = 0; g < 2; ++g) entries[e].to[g].push_back(seconds_to(run, best, kGaps[g]));
  }
  return entries;
}

Json line_of(const Entry& entry, int nodes, std::size_t factors, unsigned seed) {
  const Summary& s = entry.summary;
  const auto number = [](double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); };
  Json line;
  line["suite"] = "network";
  line["backend"] = entry.name;
  line["nodes"] = nodes;
  line["factors"] = factors;
  line["cost"] = number(s.cost);
  line["decrement"] = number(s.decrement);
  line["iterations"] = s.iterations;
  line["seconds_to_1e-4"] = number(median(entry.to[0]));
  line["seconds_to_1e-6"] = number(median(entry.to[1]));
  line["seconds"] = s.seconds;
  line["termination"] = to_string(s.termination);
  line["peak_memory_gb"] = peak_memory();
  line["repetitions"] = entry.to[0].size();
  line["seed"] = seed;
  line["commit"] = commit();
  line["machine"] = machine();
  return line;
}

void print_networks(std::ostream& out, const std::vector<Json>& lines) {
  std::vector<Table::Column> columns{{"nodes", Table::Align::right}, {"back-end", Table::Align::left}};
  for (const char* title : {"cost", "to 1e-4 [s]", "to 1e-6 [s]", "iterations", "to its end [s]", "decrement", "peak memory [GB]"})
    columns.push_back({title, Table::Align::right});
  columns.push_back({"ended", Table::Align::left});
  Table table(columns);
  const auto text = [](const Json& number, const char* format) { return number.is_number() ? cell(format, number.get<double>()) : "-"; };
  for (const Json& line : lines)
    table.add({line["nodes"].dump(), line["backend"], text(line["cost"], "%.7g"), text(line["seconds_to_1e-4"], "%.3g"),
               text(line["seconds_to_1e-6"], "%.3g"), line["iterations"].dump(), text(line["seconds"], "%.3g"),
               text(line["decrement"], "%.1e"), text(line["peak_memory_gb"], "%.2f"), line["termination"]});
  table.print(out);
}

}  // namespace

bool race_networks(const RunnerOptions& options, Journal& journal, Terminal& terminal) {
  std::vector<int> sizes{100, 1000, 10000, 100000};
  if (!options.sizes.empty()) sizes = options.sizes;
  print_head(terminal.out, suites_of({"network"}).front(),
             "one node a square metre, a tenth of them anchors, eight neighbours on average, 2 % of noise; range balls, convex; start: the "
             "centroid of the anchors. Seconds until the cost is within so much of the best that anyone found. One thread.");
  ProgressBar bar(terminal, sizes.size());
  std::vector<Json> lines;
  for (const int nodes : sizes) {
    const Instance instance = network(nodes, options.seed);
    for (const Entry& entry : solve_network(instance, nodes, options, bar)) {
      lines.push_back(line_of(entry, nodes, instance.graph.size(), options.seed));
      journal.append(lines.back());
    }
    bar.done_with_one();
  }
  bar.clear();
  print_networks(terminal.out, lines);
  terminal.out << "results: " << journal.path() << "\n" << std::endl;
  return std::all_of(lines.begin(), lines.end(), [](const Json& line) { return line["cost"].is_number(); });
}

}  // namespace holdfast::bench
