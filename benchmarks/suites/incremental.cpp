#include <algorithm>
#include <holdfast/benchmarks/race.hpp>
#include <holdfast/common/machine.hpp>
#include <holdfast/common/table.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/solvers/detail/clock.hpp>
#include <holdfast/solvers/incremental/incremental.hpp>
#include <holdfast/solvers/table.hpp>
#include <map>

namespace holdfast::bench {
namespace {

/// What comes at one step of the robot: variables, and the factors that tie nothing newer.
struct Moment {
  std::vector<Key> keys;
  std::vector<FactorId> factors;
};

struct Stream {
  std::string name;
  Instance instance;  ///< start: dead reckoning, and where a file says its landmarks are
  std::vector<Moment> moments;
};

bool is_landmark(const Values& values, Key key) {
  const PoolBase& pool = values.pool(values.slot(key).pool);
  return pool.is_vector_space() && pool.space() == pool.dim();
}

/// Poses in the order of their steps, all agents together; a landmark comes with its first factor, and with a prior of 100 m at its start
/// where it has none, so that one range does not leave it free.
Stream stream_of(std::string name, Instance instance) {
  Stream stream{std::move(name), std::move(instance), {}};
  Graph& graph = stream.instance.graph;
  const Values& values = stream.instance.start;
  std::vector<Key> poses;
  for (const Key key : values.keys())
    if (!is_landmark(values, key)) poses.push_back(key);
  std::stable_sort(poses.begin(), poses.end(), [](Key a, Key b) { return a.step() < b.step(); });
  std::map<Key, std::size_t> place;
  for (const Key key : poses) {
    place.emplace(key, stream.moments.size());
    stream.moments.push_back({{key}, {}});
  }
  constexpr double kFarAway = 100;
  for (const Key key : values.keys()) {
    if (!is_landmark(values, key)) continue;
    if (values.contains<Point2>(key))
      graph.add(Prior<Point2>::from_sigmas(values.at<Point2>(key), Vector<2>::Constant(kFarAway)), {key});
    else
      graph.add(Prior<Point3>::from_sigmas(values.at<Point3>(key), Vector<3>::Constant(kFarAway)), {key});
  }
  std::map<Key, std::vector<FactorId>> priors;  // of landmarks
  const auto for_each = [&](const auto& fn) {
    for (std::size_t b = 0; b < graph.batches().size(); ++b)
      for (int i = 0; i < graph.batches()[b]->size(); ++i) fn(*graph.batches()[b], i, graph.id_of(static_cast<int>(b), i));
  };
  for_each([&](const FactorBatch& batch, int i, FactorId id) {
    if (batch.arity() == 1 && is_landmark(values, batch.keys(i)[0])) priors[batch.keys(i)[0]].push_back(id);
  });
  std::vector<std::pair<std::size_t, FactorId>> in_time;
  for_each([&](const FactorBatch& batch, int i, FactorId id) {
    std::size_t latest = 0;
    bool any = false;
    for (int k = 0; k < batch.arity(); ++k)
      if (const auto it = place.find(batch.keys(i)[k]); it != place.end()) latest = std::max(latest, it->second), any = true;
    if (any) in_time.emplace_back(latest, id);
  });
  std::stable_sort(in_time.begin(), in_time.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& [when, id] : in_time) {
    Moment& moment = stream.moments[when];
    const Graph::Place& at = graph.place(id);
    const FactorBatch& batch = *graph.batches()[at.batch];
    for (int k = 0; k < batch.arity(); ++k) {
      const Key key = batch.keys(at.index)[k];
      if (place.count(key) != 0) continue;
      place.emplace(key, when);
      moment.keys.push_back(key);
      moment.factors.insert(moment.factors.end(), priors[key].begin(), priors[key].end());
    }
    moment.factors.push_back(id);
  }
  return stream;
}

/// Where a new pose begins: the pose that odometry ties it to, moved on by what was measured.
template <class P>
bool begin_at_odometry(const Incremental& smoother, const Graph& graph, const Moment& moment, Key key, Values& start) {
  for (const FactorId id : moment.factors) {
    const Graph::Place& at = graph.place(id);
    const FactorBatch& batch = *graph.batches()[at.batch];
    const auto* poses = dynamic_cast<const RelativePoses<P>*>(&batch);
    if (poses == nullptr) continue;
    const Key first = batch.keys(at.index)[0], second = batch.keys(at.index)[1], other = first == key ? second : first;
    if ((first != key && second != key) || other.agent() != key.agent() || other.step() + 1 != key.step()) continue;
    const P measured = poses->measured_pose(at.index).pose, from = smoother.at<P>(other);
    start.update(key, first == key ? from * measured.inverse() : from * measured);
    return true;
  }
  return false;
}

struct Score {
  std::vector<double> microseconds;
  double cost = 0, batch_cost = 0, largest_excess = 0, seconds_batch = 0;
  std::size_t variables = 0, factors = 0, relinearized = 0, eliminated = 0, steps = 0;
  int reordered = 0, batches = 0;
};

Score follow(const Stream& stream, ProgressBar& bar) {
  constexpr std::size_t kCompared = 100;  // steps from one comparison with the batch answer to the next
  Score score;
  Values start = stream.instance.start;
  const Graph& graph = stream.instance.graph;
  Incremental smoother;
  Options options;
  options.cost_tolerance = 1e-12;
  const auto batch = make_backend("irls", options);
  for (std::size_t k = 0; k < stream.moments.size(); ++k) {
    const Moment& moment = stream.moments[k];
    if (k % 500 == 0) bar.begin(stream.name + ", step " + std::to_string(k));
    const Stopwatch watch;
    for (const Key key : moment.keys) {
      if (start.contains<Pose2>(key))
        begin_at_odometry<Pose2>(smoother, graph, moment, key, start);
      else if (start.contains<Pose3>(key))
        begin_at_odometry<Pose3>(smoother, graph, moment, key, start);
      smoother.insert_from(start, key);
      if (graph.is_fixed(key)) smoother.fix(key);
    }
    for (const FactorId id : moment.factors) smoother.add_from(graph, id);
    const IncrementalStep& step = smoother.update();
    score.microseconds.push_back(1e6 * watch.seconds());
    score.relinearized += static_cast<std::size_t>(step.relinearized);
    score.eliminated += static_cast<std::size_t>(step.eliminated);
    score.steps += static_cast<std::size_t>(step.steps);
    score.reordered += step.reordered ? 1 : 0;
    score.batches += step.batch ? 1 : 0;
    if ((k + 1) % kCompared != 0 || smoother.graph().size() == 0) continue;
    Values answer = smoother.values();
    const double cost = smoother.cost(), best = batch->solve(smoother.graph(), answer).cost;
    if (best > 1e-9) score.largest_excess = std::max(score.largest_excess, (cost - best) / best);
  }
  score.cost = smoother.cost();
  score.variables = smoother.size();
  score.factors = smoother.graph().size();
  Values answer = smoother.values();
  const Summary end = batch->solve(smoother.graph(), answer);
  score.batch_cost = end.cost;
  score.seconds_batch = end.seconds;
  return score;
}

double percentile(std::vector<double> numbers, double part) {
  const std::size_t place = static_cast<std::size_t>(part * static_cast<double>(numbers.size() - 1));
  std::nth_element(numbers.begin(), numbers.begin() + static_cast<std::ptrdiff_t>(place), numbers.end());
  return numbers[place];
}

Json line_of(const Stream& stream, const Score& score, unsigned seed) {
  double total = 0;
  for (const double us : score.microseconds) total += us;
  Json line;
  line["suite"] = "incremental";
  line["file"] = stream.name;
  line["backend"] = "incremental";
  line["variables"] = score.variables;
  line["factors"] = score.factors;
  line["steps"] = score.microseconds.size();
  line["mean_us"] = total / static_cast<double>(score.microseconds.size());
  line["p99_us"] = percentile(score.microseconds, 0.99);
  line["worst_us"] = percentile(score.microseconds, 1);
  line["seconds"] = total / 1e6;
  line["cost"] = score.cost;
  line["batch_cost"] = score.batch_cost;
  line["batch_seconds"] = score.seconds_batch;
  line["largest_excess"] = score.largest_excess;
  line["gauss_newton_steps"] = score.steps;
  line["relinearized"] = score.relinearized;
  line["eliminated"] = score.eliminated;
  line["reordered"] = score.reordered;
  line["batches"] = score.batches;
  line["seed"] = seed;
  line["commit"] = commit();
  line["machine"] = machine();
  return line;
}

void print_streams(std::ostream& out, const std::vector<Json>& lines) {
  std::vector<Table::Column> columns{{"stream", Table::Align::left}};
  for (const char* title : {"steps", "factors", "mean [µs]", "p99 [µs]", "worst [µs]", "total [s]", "cost", "batch cost",
                            "largest excess over batch", "eliminated a step", "ordered afresh", "batch solves"})
    columns.push_back({title, Table::Align::right});
  Table table(columns);
  for (const Json& line : lines)
    table.add({line["file"], line["steps"].dump(), line["factors"].dump(), cell("%.1f", line["mean_us"]), cell("%.0f", line["p99_us"]),
               cell("%.0f", line["worst_us"]), cell("%.3f", line["seconds"]), cell("%.8g", line["cost"]), cell("%.8g", line["batch_cost"]),
               cell("%.1e", line["largest_excess"]), cell("%.1f", line["eliminated"].get<double>() / line["steps"].get<double>()),
               line["reordered"].dump(), line["batches"].dump()});
  table.print(out);
}

}  // namespace

bool race_incremental(const RunnerOptions& options, Journal& journal, Terminal& terminal) {
  constexpr int kCity = 10000;
  print_head(
      terminal.out, suites_of({"incremental"}).front(),
      "a pose with its edges a step, in time order, squared loss; a new pose begins where its odometry says. Time: of adding and of the "
      "update. Every 100th step is compared with the batch answer (irls from the estimate, 1e-12), outside the time.");
  std::vector<Case> cases;
  for (const char* file : {"pose_graph/CSAIL.g2o", "pose_graph/intel.g2o", "pose_graph/M3500.g2o", "pose_graph/sphere2500.g2o",
                           "range/plaza2.pyfg", "range/single_drone.pyfg"})
    cases.push_back(data_case(file, "squared", "odometry", options.seed));
  cases.push_back({"city of 10,000 poses", "squared", "odometry", [&] { return grid_walk(2, kCity, options.seed); }});
  if (!options.graphs.empty())
    cases.erase(std::remove_if(cases.begin(), cases.end(),
                               [&](const Case& one) {
                                 return std::none_of(options.graphs.begin(), options.graphs.end(),
                                                     [&](const std::string& graph) { return one.name.find(graph) != std::string::npos; });
                               }),
                cases.end());
  ProgressBar bar(terminal, cases.size());
  std::vector<Json> lines;
  for (const Case& one : cases) {
    if (!one.absent.empty()) {
      terminal.out << "skipped: " << one.name << ": " << one.absent << '\n';
      continue;
    }
    const Stream stream = stream_of(one.name, one.make());
    lines.push_back(line_of(stream, follow(stream, bar), options.seed));
    journal.append(lines.back());
    bar.done_with_one();
  }
  bar.clear();
  print_streams(terminal.out, lines);
  terminal.out << "results: " << journal.path() << "\n" << std::endl;
  return true;
}

}  // namespace holdfast::bench
