#include <algorithm>
#include <cstdio>
#include <holdfast/benchmarks/race.hpp>
#include <holdfast/common/machine.hpp>
#include <holdfast/common/table.hpp>
#include <holdfast/solvers/linear/internal/symbolic.hpp>

namespace holdfast::bench {
namespace {

constexpr int kSizes[] = {1000, 3000, 10000, 30000, 100000};
/// Beyond these, minutes of ceres would show nothing that the slope does not.
int largest_for_ceres(int space) { return space == 2 ? 30000 : 10000; }

Case walk_case(int space, int poses, unsigned seed) {
  return {"walk" + std::to_string(space) + "d-" + std::to_string(poses), "squared", "near truth",
          [space, poses, seed] { return grid_walk(space, poses, seed); }};
}

/// Of the Cholesky factor that irls keeps, zeros of its fronts and all.
double factor_megabytes(const Instance& instance) {
  const Resolved resolved(instance.graph, instance.start);
  std::vector<int> variable;
  double doubles = 0;
  for (const Symbolic::Supernode& node : analyze(block_graph(instance.graph, resolved, variable)).supernodes)
    doubles += static_cast<double>(node.n) * node.k;
  return 8e-6 * doubles;
}

struct Point {
  double size, value;
};

/// Least squares of log(value) on log(size).
double slope(const std::vector<Point>& points) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const Point& point : points) {
    const double u = std::log(point.size), v = std::log(point.value);
    n += 1, x += u, y += v, xx += u * u, xy += u * v;
  }
  return points.size() < 2 ? std::numeric_limits<double>::quiet_NaN() : (n * xy - x * y) / (n * xx - x * x);
}

std::vector<Point> seconds_of(const std::string& backend, const std::string& walk, const std::vector<Json>& lines) {
  std::vector<Point> points;
  for (const Json& line : lines)
    if (line["backend"] == backend && line["threads"] == 1 && line["termination"] == "converged" &&
        line["file"].get<std::string>().rfind(walk, 0) == 0)
      points.push_back({line["variables"].get<double>(), line["seconds"].get<double>()});
  return points;
}

std::vector<Point> memory_of(int space, unsigned seed) {
  std::vector<Point> memory;
  for (const int poses : kSizes) memory.push_back({double(poses), factor_megabytes(grid_walk(space, poses, seed))});
  return memory;
}

/// For scripts/plot-growth.
Json memory_line(const std::string& walk, const Point& point, unsigned seed) {
  return {{"suite", "pose-graph"}, {"walk", walk},       {"variables", point.size}, {"factor_megabytes", point.value},
          {"seed", seed},          {"commit", commit()}, {"machine", machine()}};
}

void print_slopes(std::ostream& out, const std::vector<Json>& lines, unsigned seed, Journal& journal) {
  Table table({{"growth", Table::Align::left}, {"of", Table::Align::left}, {"slope, log–log", Table::Align::right}});
  const auto add = [&](const std::string& walk, const std::string& of, const std::vector<Point>& points) {
    char text[20];
    std::snprintf(text, sizeof text, "%.2f", slope(points));
    table.add({walk, of, text});
  };
  for (const int space : {2, 3}) {
    const std::string walk = "walk" + std::to_string(space) + "d";
    for (const char* backend : {"ceres", "irls"}) {
      const int largest = largest_for_ceres(space);
      std::vector<Point> points = seconds_of(backend, walk, lines);
      add(walk, std::string(backend) + " seconds, all sizes", points);
      points.erase(std::remove_if(points.begin(), points.end(), [=](const Point& point) { return point.size > largest; }), points.end());
      add(walk, std::string(backend) + " seconds, to " + std::to_string(largest), points);
    }
    const std::vector<Point> memory = memory_of(space, seed);
    for (const Point& point : memory) journal.append(memory_line(walk, point, seed));
    char text[60];
    std::snprintf(text, sizeof text, "irls factor, %.3g to %.3g MB", memory.front().value, memory.back().value);
    add(walk, text, memory);
  }
  table.print(out);
}

std::vector<Entrant> growth_entrants(int space, int poses) {
  std::vector<Entrant> entrants;
  for (const std::string& backend : race_backends())
    if (backend == "irls" || (backend == "ceres" && poses <= largest_for_ceres(space))) entrants.push_back({backend, 1});
  return entrants;
}

}  // namespace

std::vector<Case> pose_graph_cases(unsigned seed) {
  std::vector<Case> cases;
  const auto add = [&](const char* name, const char* start) {
    cases.push_back(data_case("pose_graph/" + std::string(name) + ".g2o", "squared", start, seed));
  };
  add("intel", "file");
  for (const char* start : {"file", "odometry"}) add("M3500", start);
  for (const char* name : {"MIT", "CSAIL", "sphere2500", "smallGrid3D"}) add(name, "file");
  return cases;
}

bool race_pose_graphs(const RunnerOptions& asked, Journal& journal, Terminal& terminal) {
  const Suite suite = suites_of({"pose-graph"}).front();
  const RunnerOptions options = race_options(asked);
  print_head(terminal.out, suite,
             "Squared loss, tolerance 1e-6; the whole solve() of a fresh back-end object, setup and all, median of " +
                 std::to_string(options.repetitions) +
                 " in turn where it takes less than a second, else one. One thread, irls with two as " + "well. Walks of more than " +
                 std::to_string(largest_for_ceres(2)) + " poses in the plane, " + std::to_string(largest_for_ceres(3)) +
                 " in space: irls alone.");
  const std::vector<Case> cases = suite.cases(options.seed);
  std::vector<Entrant> entrants = entrants_of(options.backends, 1);
  entrants.push_back({"irls", 2});
  ProgressBar bar(terminal, cases.size() * entrants.size() + 4 * std::size(kSizes) - 3);
  Runner runner(suite, kRacePolicy, options, journal, bar);
  SuiteResult result, growth;
  for (const Case& one : cases) runner.run(one, entrants, result);
  for (const int space : {2, 3})
    for (const int poses : kSizes) runner.run(walk_case(space, poses, options.seed), growth_entrants(space, poses), growth);
  bar.clear();
  print_race(terminal.out, result.lines);
  terminal.out << '\n';
  print_race(terminal.out, growth.lines);
  print_slopes(terminal.out, growth.lines, options.seed, journal);
  const bool files_well = print_end(terminal, result, journal.path());
  return print_end(terminal, growth, journal.path()) && files_well;
}

}  // namespace holdfast::bench
