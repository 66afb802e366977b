#include <algorithm>
#include <filesystem>
#include <holdfast/benchmarks/scenarios/random.hpp>
#include <holdfast/benchmarks/suites/false_loops.hpp>
#include <holdfast/factors/between.hpp>
#include <holdfast/graph/files/files.hpp>
#include <holdfast/solvers/chi_square.hpp>
#include <holdfast/solvers/irls/irls.hpp>

namespace holdfast::bench {
namespace {

using Kind = FalseLoops::Kind;

/// A graph of one type of pose.
template <class Pose>
class Attacker {
  static constexpr int dim = Pose::dim, space = Pose::space_dim;

 public:
  Attacker(AttackedGraph& out, unsigned seed) : out_(out), random_(seed) {
    out.clean.for_each<Pose>([&](Key key, const Pose&) { keys_.push_back(key); });
    std::sort(keys_.begin(), keys_.end());
    for (const Key key : keys_) extent_ = std::max(extent_, (out.clean.at<Pose>(key).p - out.clean.at<Pose>(keys_[0]).p).norm());
    W_ = out.graph.at<Between<Pose>>(out.true_loops.front()).sqrt_information;
  }

  void add(const FalseLoops& attack) {
    const auto count = static_cast<std::size_t>(std::lround(attack.share * static_cast<double>(out_.true_loops.size())));
    const std::size_t group = attack.kind == Kind::grouped || attack.kind == Kind::local_groups ? 10 : 1;
    while (out_.false_loops.size() < count) {
      const int n = static_cast<int>(keys_.size());
      int i = random_.index(n), j = random_.index(n);
      if (attack.kind == Kind::local || attack.kind == Kind::local_groups) j = std::min(n - 1, i + 2 + random_.index(19));
      if (std::abs(i - j) < 2) continue;
      Pose z = measured(attack.kind, i, j);
      for (std::size_t g = 0; g < group && out_.false_loops.size() < count; ++g, ++i, ++j) {
        if (i >= n || j >= n || std::abs(i - j) < 2) break;
        if (g > 0) z = step(i).inverse() * z * step(j);  // the next pair, as both have moved on
        out_.false_loops.push_back(out_.graph.add(Between<Pose>{g > 0 ? z.retract(noise()) : z, W_}, {keys_[i], keys_[j]}));
      }
    }
  }

 private:
  /// What the odometry says of the way from the pose before.
  Pose step(int i) const { return out_.start.at<Pose>(keys_[i - 1]).inverse() * out_.start.at<Pose>(keys_[i]); }
  Vector<dim> noise() { return Matrix<dim, dim>(W_).inverse() * random_.normals<dim>(1); }
  Pose measured(Kind kind, int i, int j) {
    constexpr double kPlace = 0.3, kTurn = kPi / 18;  // [m], [rad]
    Vector<dim> delta;
    if (kind == Kind::near_truth) {
      delta = random_.normals<dim>(1).normalized() * std::sqrt(chi_square_quantile(0.95, dim) + random_.uniform(0, 50));
      return (out_.clean.at<Pose>(keys_[i]).inverse() * out_.clean.at<Pose>(keys_[j])).retract(Matrix<dim, dim>(W_).inverse() * delta);
    }
    if (kind == Kind::random)
      for (int k = 0; k < dim; ++k) delta[k] = k < space ? random_.uniform(-extent_, extent_) : random_.uniform(-kPi, kPi);
    else
      for (int k = 0; k < dim; ++k) delta[k] = (k < space ? kPlace : kTurn) * random_.normal();
    return Pose{}.retract(delta);
  }

  AttackedGraph& out_;
  Random random_;
  std::vector<Key> keys_;
  double extent_ = 0;
  Matrix<dim, dim> W_;
};

void sort_out(const Problem& problem, AttackedGraph& out) {
  for (const FactorId id : problem.factors) {
    const Graph::Place& place = problem.graph.place(id);
    const FactorBatch& batch = *problem.graph.batches()[place.batch];
    if (batch.arity() != 2) continue;
    const Key* const keys = batch.keys(place.index);
    const bool follow =
        keys[0].agent() == keys[1].agent() && std::max(keys[0].step(), keys[1].step()) - std::min(keys[0].step(), keys[1].step()) == 1;
    (follow ? out.odometry : out.true_loops).push_back(id);
  }
}

}  // namespace

const char* to_string(Kind kind) {
  switch (kind) {
    case Kind::random:
      return "random";
    case Kind::at_one_place:
      return "at one place";
    case Kind::local:
      return "local";
    case Kind::grouped:
      return "grouped";
    case Kind::local_groups:
      return "local groups";
    case Kind::near_truth:
      return "near truth";
  }
  return "";
}

std::optional<AttackedGraph> attacked(const std::string& file, const FalseLoops& attack, unsigned seed) {
  const std::string path = (std::filesystem::path(data_directory()) / "pose_graph" / (file + ".g2o")).string();
  if (!std::filesystem::is_regular_file(path)) return std::nullopt;
  ProblemOptions options;
  options.start = ProblemOptions::Start::odometry;
  const Problem problem = make_problem(read_dataset(path), options);
  AttackedGraph out{problem.graph, problem.start, problem.start, {}, {}, {}, {}};
  sort_out(problem, out);
  Options to_the_bottom;
  to_the_bottom.cost_tolerance = 1e-12;
  Irls(to_the_bottom).solve(problem.graph, out.clean);
  int planar = 0;
  out.clean.for_each<Pose2>([&](Key, const Pose2&) { ++planar; });
  if (planar > 0)
    Attacker<Pose2>(out, seed).add(attack);
  else
    Attacker<Pose3>(out, seed).add(attack);
  return out;
}

const char* to_string(FalseRanges::Kind kind) {
  switch (kind) {
    case FalseRanges::Kind::echoes:
      return "echoes";
    case FalseRanges::Kind::no_line_of_sight:
      return "no line of sight";
    case FalseRanges::Kind::as_it_is:
      return "as it is";
  }
  return "";
}

std::optional<AttackedGraph> attacked(const std::string& file, const FalseRanges& attack, unsigned seed) {
  const std::string path = (std::filesystem::path(data_directory()) / "range" / (file + ".pyfg")).string();
  if (!std::filesystem::is_regular_file(path)) return std::nullopt;
  ProblemOptions options;
  options.start = ProblemOptions::Start::odometry;
  options.seed = seed;
  common::FileProblem whole = common::load(path, options);
  Dataset& dataset = whole.dataset;
  Random random(seed);
  std::vector<bool> is_false(dataset.edges.size(), false);
  for (std::size_t i = 0; i < dataset.edges.size(); ++i) {
    auto* const range = std::get_if<RangeEdge>(&dataset.edges[i].measurement);
    if (range == nullptr || attack.kind == FalseRanges::Kind::as_it_is || !random.chance(attack.share)) continue;
    is_false[i] = true;
    range->distance += attack.kind == FalseRanges::Kind::echoes ? random.uniform(1, 20) : -2 * std::log1p(-random.uniform());
  }
  Problem problem = make_problem(dataset, options);
  AttackedGraph out{std::move(problem.graph), problem.start, whole.instance.start, whole.instance.truth, {}, {}, {}};
  for (std::size_t i = 0; i < dataset.edges.size(); ++i)
    if (std::holds_alternative<RangeEdge>(dataset.edges[i].measurement))
      (is_false[i] ? out.false_loops : out.true_loops).push_back(problem.factors[i]);
    else
      out.odometry.push_back(problem.factors[i]);
  Options to_the_bottom;
  to_the_bottom.cost_tolerance = 1e-12;
  Irls(to_the_bottom).solve(whole.instance.graph, out.clean);
  return out;
}

}  // namespace holdfast::bench
