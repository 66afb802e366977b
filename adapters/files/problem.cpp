#include <holdfast/adapters/files/edge_to_factor.hpp>
#include <holdfast/adapters/files/problem.hpp>
#include <holdfast/adapters/files/vertex_value.hpp>
#include <holdfast/graph/starts/chordal.hpp>
#include <map>
#include <unordered_map>

namespace holdfast {
namespace {

class Builder {
 public:
  Builder(const Dataset& dataset, const ProblemOptions& options) : dataset_(dataset), options_(options) {}

  Problem build() {
    problem_.start = start();
    const std::vector<bool> odometry = odometry_edges(dataset_, options_.odometry);
    for (std::size_t i = 0; i < dataset_.edges.size(); ++i) {
      const Measurement& measurement = dataset_.edges[i].measurement;
      problem_.factors.push_back(add(measurement, odometry[i] ? Loss{} : options_.loss));
      if (odometry[i]) std::visit([&](const auto& edge) { note_odometry(edge); }, measurement);
    }
    bool any_fixed = false;
    for (const Fixed& fixed : dataset_.fixed) {
      if (!problem_.start.contains(fixed.key)) continue;  // check(dataset) says so
      problem_.graph.fix(fixed.key);
      any_fixed = true;
    }
    if (!has_prior_ && !any_fixed) hold_the_world();
    if (options_.start == ProblemOptions::Start::convex) start_convex();
    return std::move(problem_);
  }

 private:
  Values start() const {
    switch (options_.start) {
      case ProblemOptions::Start::odometry:
        return odometry_start(dataset_, options_.seed);
      case ProblemOptions::Start::chordal:
      case ProblemOptions::Start::convex:
        return chordal_start(dataset_);
      default:
        return vertex_start(dataset_);
    }
  }

  void start_convex() {
    problem_.relaxed = relaxed_start(problem_.graph, problem_.start);
    if (!problem_.relaxed->relaxed.usable()) fail<BadProblem>("the convex start: ", problem_.relaxed->relaxed.why());
  }

  FactorId add(const Measurement& measurement, const Loss& loss) {
    return edge_to_factor(measurement, problem_.start, [&](const auto& factor, auto... keys) {
      constexpr bool is_prior = sizeof...(keys) == 1;
      if (is_prior) has_prior_ = true;
      return problem_.graph.add(factor, {keys...}, is_prior ? Loss{} : loss);
    });
  }
  template <class V>
  bool is(Key key) const {
    return problem_.start.contains<V>(key);
  }

  template <class M>
  void note_odometry(const M&) {}
  template <class V>
  void note_odometry(const RelativePoseEdge<V>& edge) {
    first_odometry_.try_emplace(edge.first.agent(), edge.information());
  }

  void hold_the_world() {
    for (const Vertex& vertex : dataset_.vertices) vertices_.emplace(vertex.key, &vertex.value);
    std::map<Agent, Key> first_pose;
    for (Key key : problem_.start.keys())
      if (is<Pose2>(key) || is<Pose3>(key)) first_pose.try_emplace(key.agent(), key);
    for (const auto& [agent, key] : first_pose) {
      if (dataset_.format != Format::PyFG) {
        problem_.graph.fix(key);
        return;
      }
      hold(key);
    }
  }
  void hold(Key key) {
    const auto information = first_odometry_.find(key.agent());
    if (information == first_odometry_.end()) {
      problem_.graph.fix(key);
    } else if (is<Pose2>(key)) {
      problem_.graph.add(Prior<Pose2>::from_information(true_pose<Pose2>(key), information->second), {key});
    } else {
      problem_.graph.add(Prior<Pose3>::from_information(true_pose<Pose3>(key), information->second), {key});
    }
  }
  template <class V>
  V true_pose(Key key) const {
    const auto vertex = vertices_.find(key);
    const V* pose = vertex == vertices_.end() ? nullptr : std::get_if<V>(vertex->second);
    return pose != nullptr ? *pose : problem_.start.at<V>(key);
  }

  const Dataset& dataset_;
  const ProblemOptions& options_;
  Problem problem_;
  bool has_prior_ = false;
  std::map<Agent, Eigen::MatrixXd> first_odometry_;
  std::unordered_map<Key, const VertexValue*> vertices_;
};

}  // namespace

ProblemOptions::Start start_named(const std::string& name) {
  if (name == "file") return ProblemOptions::Start::file;
  if (name == "odometry") return ProblemOptions::Start::odometry;
  if (name == "chordal") return ProblemOptions::Start::chordal;
  if (name == "convex") return ProblemOptions::Start::convex;
  fail<BadOption>("there is no start '", name, "'; there are: file odometry chordal convex");
}

Problem make_problem(const Dataset& dataset, const ProblemOptions& options) { return Builder(dataset, options).build(); }

Dataset with_values(const Dataset& dataset, const Values& values) {
  Dataset result = dataset;
  std::map<Key, Vertex*> known;
  for (Vertex& vertex : result.vertices) known[vertex.key] = &vertex;
  std::vector<Vertex> missing;
  for (Key key : values.keys()) {
    const std::optional<VertexValue> value = vertex_value(values, key);
    if (!value) continue;
    const auto it = known.find(key);
    if (it != known.end())
      it->second->value = *value;
    else
      missing.push_back({key, *value, {}, {}, 0});
  }
  result.vertices.insert(result.vertices.end(), missing.begin(), missing.end());
  return result;
}

}  // namespace holdfast
