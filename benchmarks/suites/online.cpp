#include <time.h>

#include <algorithm>
#include <fstream>
#include <holdfast/benchmarks/race.hpp>
#include <holdfast/benchmarks/scenarios/random.hpp>
#include <holdfast/common/machine.hpp>
#include <holdfast/common/table.hpp>
#include <holdfast/factors/huber_measurement.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/factors/white_acceleration.hpp>
#include <holdfast/solvers/window/window.hpp>

namespace holdfast::bench {
namespace {

using Motion = WhiteAcceleration<Motion2>;
using Position = HuberMeasurement<Motion2>;

constexpr Agent A('A');
const Matrix<4, 4> I4 = Matrix<4, 4>::Identity();
const Matrix<2, 2> I2 = Matrix<2, 2>::Identity();

/// Agents that move by white acceleration (R = I), each step measured by its position, and by the ranges between them.
class Fleet {
 public:
  struct Options {
    int agents = 1;
    double dt = 0.05;
    double outliers = 0.2, lost = 0;
    Loss loss = per_component(Huber{2}), motion_loss;
    WindowOptions window;
  };
  Fleet(const Options& options, unsigned seed) : options_(options), random_(seed), window_(options.window) {
    for (int a = 0; a < options.agents; ++a) {
      const Agent agent = agent_of(static_cast<std::size_t>(a));
      const Motion2 start(20.0 * a, 1.0, -10.0 * a, -1.0);
      truth_.push_back(start);
      truth_.back().value += random_.normals<4>(1);
      window_.add_agent(agent, Motion::exact(options.dt, 1, I4), options.dt, options.motion_loss);
      window_.add_state(agent(0), 0.0, start);
      window_.add(Prior<Motion2>::from_sigmas(start, Vector<4>::Ones()), {agent(0)});
    }
  }
  const WindowStep& step() {
    const double t = ++k_ * options_.dt;
    for (std::size_t a = 0; a < truth_.size(); ++a) {
      truth_[a].value = predicted(truth_[a], options_.dt) + noise();
      const Agent agent = agent_of(a);
      const Key key = window_.at(agent, t);
      if (random_.chance(options_.lost)) continue;
      window_.add(Position::of_position(-truth_[a].position() + error<2>(), Vector<2>(0, 0), I2), {key}, options_.loss);
    }
    for (std::size_t a = 0; a < truth_.size(); ++a)
      for (std::size_t b = 0; b < a; ++b) {
        if (random_.chance(options_.lost)) continue;
        const double distance = (truth_[a].position() - truth_[b].position()).norm() + 0.5 * error<1>()[0];
        window_.add(Range<Motion2, Motion2>{std::max(0.0, distance), 0.5}, {window_.at(agent_of(a), t), window_.at(agent_of(b), t)},
                    options_.loss);
      }
    return window_.step(t);
  }
  /// (x̂ − x)ᵀ C⁻¹ (x̂ − x) of the first agent's newest state.
  double nees() const {
    const Key key = window_.newest_key('A');
    const Vector<4> e = truth_[0].local(window_.newest<Motion2>('A'));
    return e.dot(Marginals(window_.graph(), window_.values()).covariance<Motion2>(key).inverse() * e);
  }
  /// [t, x̂ − x, 3σ of x] of the first agent's newest state [s, m, m].
  Json error_of_x() const {
    const Vector<4> e = truth_[0].local(window_.newest<Motion2>('A'));
    const Matrix<4, 4> C = Marginals(window_.graph(), window_.values()).covariance<Motion2>(window_.newest_key('A'));
    return {k_ * options_.dt, e[0], 3 * std::sqrt(C(0, 0))};
  }

 private:
  static Agent agent_of(std::size_t number) { return Agent('A', number); }
  Vector<4> noise() {
    const Vector<4> w = random_.normals<4>(1);
    const double g = options_.dt * options_.dt / 2;
    return {g * w[0], options_.dt * w[1], g * w[2], options_.dt * w[3]};
  }
  template <int N>
  Vector<N> error() {
    Vector<N> e = random_.normals<N>(1);
    if (random_.chance(options_.outliers)) e += random_.uniforms<N>(40, 70);
    return e;
  }

  Options options_;
  Random random_;
  Window window_;
  std::vector<Motion2> truth_;
  int k_ = 0;
};

/// Seconds of processor that this thread has had: what else the machine does is not in them.
double processor_seconds() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Of this process [MB].
double resident() {
  std::ifstream file("/proc/self/statm");
  double pages = 0, in_memory = 0;
  file >> pages >> in_memory;
  return in_memory * 4096e-6;
}

struct Timed {
  std::string name;
  Fleet::Options options;
  int steps;
};

std::vector<Timed> timed() {
  Fleet::Options paper;  // 15 states in each solve
  paper.motion_loss = paper.loss;
  paper.window.max_states = 14;
  paper.window.solver.cost_tolerance = 1e-4;
  paper.window.leaving = WindowOptions::Leaving::drop;
  Fleet::Options kept = paper;
  kept.window.leaving = WindowOptions::Leaving::marginalize;
  Fleet::Options five;
  five.agents = 5;
  five.dt = 0.1;
  five.lost = 0.2;
  five.loss = Huber{2};
  five.window.lag = 1;
  return {{"paper A, 15 states, dropped", paper, 1'000'000},
          {"paper A, 15 states, marginalised", kept, 1'000'000},
          {"5 agents at 10 Hz, lag 1 s, ranges", five, 10'000}};
}

/// [[simulated seconds, median µs, worst µs], …] of a hundred slices of all steps, in their order: whether it slows down.
Json over_time(const std::vector<double>& microseconds, double dt) {
  constexpr std::size_t kSlices = 100;
  Json slices = Json::array();
  for (std::size_t i = 0; i < kSlices; ++i) {
    const auto from = static_cast<std::ptrdiff_t>(microseconds.size() * i / kSlices),
               to = static_cast<std::ptrdiff_t>(microseconds.size() * (i + 1) / kSlices);
    const std::vector<double> slice(microseconds.begin() + from, microseconds.begin() + to);
    slices.push_back({static_cast<double>(to) * dt, median(slice), *std::max_element(slice.begin(), slice.end())});
  }
  return slices;
}

Json time(const Timed& row, unsigned seed, ProgressBar& bar) {
  bar.begin(row.name);
  Fleet fleet(row.options, seed);
  constexpr int kWarm = 1000;
  std::vector<double> microseconds(row.steps, 1.0);  // touched now, so that no page of it comes later
  microseconds.clear();
  double add = 0, solve = 0, marginalize = 0, before = 0, worst_on_processor = 0;
  int failed = 0;
  for (int k = 0; k < kWarm + row.steps; ++k) {
    const double start = processor_seconds();
    const WindowStep& step = fleet.step();
    if (k < kWarm) continue;
    worst_on_processor = std::max(worst_on_processor, processor_seconds() - start);  // the simulation, too
    if (k == kWarm) before = resident();
    microseconds.push_back(1e6 * step.seconds.total());
    add += step.seconds.add;
    solve += step.seconds.solve;
    marginalize += step.seconds.marginalize;
    failed += !step.summary.usable();
  }
  const double grown = resident() - before;
  bar.done_with_one();
  Json line;
  line["window"] = row.name;
  line["steps"] = row.steps;
  line["median_us"] = median(microseconds);
  line["over_time"] = over_time(microseconds, row.options.dt);
  std::sort(microseconds.begin(), microseconds.end());
  line["p99_us"] = microseconds[microseconds.size() * 99 / 100];
  line["worst_us"] = microseconds.back();
  line["worst_on_processor_us"] = 1e6 * worst_on_processor;
  line["add_us"] = 1e6 * add / row.steps;
  line["solve_us"] = 1e6 * solve / row.steps;
  line["marginalize_us"] = 1e6 * marginalize / row.steps;
  line["memory_growth_mb"] = grown;
  line["failed"] = failed;
  return line;
}

/// ANEES over runs / 4, which is 1 for a filter that knows its errors; 95 % of such means are within the band.
Json consistency(const std::string& name, double outliers, const Loss& loss, int runs, unsigned seed, ProgressBar& bar) {
  bar.begin(name);
  double sum = 0;
  Json errors = Json::array();
  for (int run = 0; run < runs; ++run) {
    Fleet::Options options;
    options.outliers = outliers;
    options.loss = loss;
    options.window.max_states = 14;
    options.window.solver.cost_tolerance = 1e-10;
    Fleet fleet(options, seed + run);
    for (int k = 0; k < 100; ++k) {
      fleet.step();
      if (run == 0) errors.push_back(fleet.error_of_x());
    }
    sum += fleet.nees() / 4;
  }
  bar.done_with_one();
  Json line;
  line["window"] = name;
  line["runs"] = runs;
  line["anees"] = sum / runs;
  line["band_95"] = 1.96 * std::sqrt(2.0 / (4 * runs));
  line["errors"] = std::move(errors);  // of the first run
  return line;
}

}  // namespace

bool race_online(const RunnerOptions& options, Journal& journal, Terminal& terminal) {
  constexpr int kRuns = 500;
  print_head(
      terminal.out, suites_of({"online"}).front(),
      "A step is all of it: adding, solving (irls), letting the oldest leave; covariances are asked for nowhere but in ANEES. Positions "
      "with sigma 1 m, ranges 0.5 m, 20 % outliers of 40 to 70 sigmas.");
  ProgressBar bar(terminal, 6);
  std::vector<Json> lines;
  Table steps({{"window", Table::Align::left},
               {"steps", Table::Align::right},
               {"median [µs]", Table::Align::right},
               {"p99 [µs]", Table::Align::right},
               {"worst [µs]", Table::Align::right},
               {"worst on the processor", Table::Align::right},
               {"add, mean", Table::Align::right},
               {"solve", Table::Align::right},
               {"leave", Table::Align::right},
               {"memory [MB]", Table::Align::right},
               {"failed", Table::Align::right}});
  for (const Timed& row : timed()) {
    const Json line = lines.emplace_back(time(row, options.seed, bar));
    steps.add({line["window"], line["steps"].dump(), cell("%.1f", line["median_us"]), cell("%.1f", line["p99_us"]),
               cell("%.0f", line["worst_us"]), cell("%.1f", line["add_us"]), cell("%.1f", line["solve_us"]),
               cell("%.1f", line["marginalize_us"]), cell("%+.2f", line["memory_growth_mb"]), line["failed"].dump()});
  }
  Table anees({{"marginalised window of 14 states, after 100 steps", Table::Align::left},
               {"runs", Table::Align::right},
               {"ANEES / 4", Table::Align::right},
               {"95 % band", Table::Align::right}});
  const auto consistent = [&](const std::string& name, double outliers, const Loss& loss) {
    const Json line = lines.emplace_back(consistency(name, outliers, loss, kRuns, options.seed, bar));
    anees.add({line["window"], line["runs"].dump(), cell("%.3f", line["anees"]), cell("1 ± %.3f", line["band_95"])});
  };
  consistent("Gaussian noise, squared", 0, Squared{});
  consistent("20 % outliers, truncated squares 4", 0.2, TruncatedSquares{4});
  consistent("20 % outliers, Huber 2 per component", 0.2, per_component(Huber{2}));
  bar.clear();
  for (Json& line : lines) {
    line["suite"] = "online";
    line["seed"] = options.seed;
    line["commit"] = commit();
    line["machine"] = machine();
    journal.append(line);
  }
  steps.print(terminal.out);
  terminal.out << '\n';
  anees.print(terminal.out);
  terminal.out << "results: " << journal.path() << "\n" << std::endl;
  return std::none_of(lines.begin(), lines.end(), [](const Json& line) { return line.value("failed", 0) > 0; });
}

}  // namespace holdfast::bench
