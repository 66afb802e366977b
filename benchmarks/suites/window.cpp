#include <algorithm>
#include <holdfast/benchmarks/race.hpp>
#include <holdfast/benchmarks/scenarios/scenario.hpp>
#include <holdfast/common/machine.hpp>
#include <holdfast/common/table.hpp>
#include <holdfast/factors/huber_measurement.hpp>
#include <holdfast/factors/white_acceleration.hpp>
#include <holdfast/solvers/irls/irls.hpp>
#include <holdfast/solvers/table.hpp>

namespace holdfast::bench {
namespace {

using Measurement = HuberMeasurement<Motion2>;

constexpr Agent A('A');

std::vector<Measurement> measurements_of(const Graph& graph) {
  std::vector<Measurement> all;
  graph.for_each_batch<Measurement>(
      [&](const Batch<Measurement>& batch) { all.insert(all.end(), batch.factors().begin(), batch.factors().end()); });
  return all;
}

/// Paper A's window (7)–(10): the motion is whitened by P = F P* Fᵀ + G R Gᵀ with P* = I, and Huber is laid on it, too. Measurements are
/// exchanged in place: the structure, and all that a back-end made of it, stays.
class Window {
 public:
  explicit Window(unsigned seed) {
    const UnicycleOptions options;
    const Instance made = unicycle(options, seed);
    const Matrix<4, 4> I = Matrix<4, 4>::Identity();
    const auto motion = WhiteAcceleration<Motion2>::recursive(options.dt, 1, I, I);
    for (const Measurement& measurement : measurements_of(made.graph)) {
      const int k = static_cast<int>(ids_.size());
      ids_.push_back(graph_.add(measurement, {A(k)}));
      if (k > 0) graph_.add(motion, {A(k - 1), A(k)}, per_component(Huber{2}));
    }
    start_ = made.start;
  }
  void move_to(unsigned seed) {
    const Instance next = unicycle({}, seed);
    const std::vector<Measurement> measurements = measurements_of(next.graph);
    for (std::size_t k = 0; k < ids_.size(); ++k) {
      graph_.at<Measurement>(ids_[k]) = measurements[k];
      start_.update(A(k), next.start.at<Motion2>(A(k)));
    }
  }
  const Graph& graph() const { return graph_; }
  const Values& start() const { return start_; }

 private:
  Graph graph_;
  Values start_;
  std::vector<FactorId> ids_;
};

/// One back-end object, which solves all windows.
struct Row {
  std::string name;
  Options options;
  std::unique_ptr<Backend> backend;
  Values values;
  std::vector<double> microseconds, costs;
  double iterations = 0;
  int at_limit = 0;
  bool failed = false;

  void solve(const Window& window) {
    values.assign(window.start());
    const Summary summary = backend->solve(window.graph(), values);
    microseconds.push_back(1e6 * summary.seconds);
    costs.push_back(summary.cost);
    iterations += summary.iterations;
    if (summary.termination == Termination::iteration_limit) ++at_limit;
    if (!summary.usable()) failed = true;
  }
};

std::vector<Row> rows(const RunnerOptions& asked, const Values& start) {
  std::vector<Row> all;
  for (const double tolerance : {1e-8, 1e-4}) {
    Options options = asked.solver;
    options.threads = 1;
    options.cost_tolerance = tolerance;
    options.max_iterations = suites_of({"window"}).front().max_iterations;
    const auto add = [&](const std::string& name, std::unique_ptr<Backend> backend) {
      all.push_back({name, options, std::move(backend), start, {}, {}});
    };
    for (const std::string& backend : race_backends())
      if (backend.find('-') == std::string::npos) add(backend, make_backend(backend, options));
    add("irls(reweighting=irls)", std::make_unique<Irls>(options, IrlsOptions{Reweighting::irls}));
  }
  return all;
}

double mean(const std::vector<double>& numbers) {
  double sum = 0;
  for (const double number : numbers) sum += number;
  return sum / static_cast<double>(numbers.size());
}

/// Over the lowest cost that anybody found, window by window.
double largest_excess(const Row& row, const std::vector<Row>& all) {
  double largest = 0;
  for (std::size_t w = 0; w < row.costs.size(); ++w) {
    double best = row.costs[w];
    for (const Row& other : all) best = std::min(best, other.costs[w]);
    largest = std::max(largest, (row.costs[w] - best) / best);
  }
  return largest;
}

Json line_of(const Row& row, const std::vector<Row>& all, unsigned seed) {
  Json line;
  line["suite"] = "window";
  line["backend"] = row.name;
  line["tolerance"] = row.options.cost_tolerance;
  line["windows"] = row.costs.size();
  line["median_us"] = median(row.microseconds);
  line["mean_us"] = mean(row.microseconds);
  line["p95_us"] = percentile_95(row.microseconds);
  line["iterations_mean"] = row.iterations / static_cast<double>(row.costs.size());
  line["largest_excess"] = largest_excess(row, all);
  line["at_limit"] = row.at_limit;
  line["failed"] = row.failed;
  line["max_iterations"] = row.options.max_iterations;
  line["seed"] = seed;
  line["commit"] = commit();
  line["machine"] = machine();
  return line;
}

void print_windows(std::ostream& out, const std::vector<Json>& lines) {
  std::vector<Table::Column> columns{{"back-end", Table::Align::left}};
  for (const char* title : {"tolerance", "median [µs]", "mean [µs]", "p95 [µs]", "iterations", "ceres/this, medians", "ceres/this, means",
                            "largest excess", "at the limit"})
    columns.push_back({title, Table::Align::right});
  Table table(columns);
  for (const Json& line : lines) {
    const auto ratio = [&](const char* field) -> std::string {
      for (const Json& other : lines)
        if (other["backend"] == "ceres" && other["tolerance"] == line["tolerance"])
          return cell("%.2f", other[field].get<double>() / line[field].get<double>());
      return "-";
    };
    table.add({line["backend"], cell("%g", line["tolerance"]), cell("%.1f", line["median_us"]), cell("%.1f", line["mean_us"]),
               cell("%.1f", line["p95_us"]), cell("%.1f", line["iterations_mean"]), ratio("median_us"), ratio("mean_us"),
               cell("%.1e", line["largest_excess"]), line["at_limit"].dump()});
  }
  table.print(out);
}

}  // namespace

std::vector<Json> window_lines(const RunnerOptions& options, unsigned windows, ProgressBar& bar) {
  Window window(options.seed);
  std::vector<Row> all = rows(options, window.start());
  for (unsigned w = 0; w < windows; ++w) {
    bar.begin("window " + std::to_string(w));
    window.move_to(options.seed + w);
    for (Row& row : all) row.solve(window);
    bar.done_with_one();
  }
  std::vector<Json> lines;
  for (const Row& row : all) lines.push_back(line_of(row, all, options.seed));
  return lines;
}

bool race_windows(const RunnerOptions& options, Journal& journal, Terminal& terminal) {
  constexpr unsigned kWindows = 1000;
  print_head(terminal.out, suites_of({"window"}).front(),
             "15 states, 86 scalar residuals, Huber 2 on each, 20 % gross outliers; at most 200 iterations; one back-end object a row "
             "solves all windows, "
             "measurements changed in place, start at the measurements; the rows in turn, window by window. Excess: relative to the best "
             "cost of any row.");
  ProgressBar bar(terminal, kWindows);
  const std::vector<Json> lines = window_lines(options, kWindows, bar);
  bar.clear();
  for (const Json& line : lines) journal.append(line);
  print_windows(terminal.out, lines);
  terminal.out << "results: " << journal.path() << "\n" << std::endl;
  return std::none_of(lines.begin(), lines.end(), [](const Json& line) { return line["failed"] == true; });
}

}  // namespace holdfast::bench
