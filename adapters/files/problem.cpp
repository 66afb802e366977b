#include <holdfast/adapters/files/problem.hpp>
#include <holdfast/factors/between.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/factors/relative_point.hpp>
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
    const std::vector<bool> odometry = odometry_edges(dataset_);
    for (std::size_t i = 0; i < dataset_.edges.size(); ++i) {
      const Loss loss = odometry[i] ? Loss{} : options_.loss;
      problem_.factors.push_back(
          std::visit([&](const auto& measurement) { return add(measurement, loss); }, dataset_.edges[i].measurement));
      if (odometry[i]) std::visit([&](const auto& measurement) { note_odometry(measurement); }, dataset_.edges[i].measurement);
    }
    for (const Fixed& fixed : dataset_.fixed) problem_.graph.fix(fixed.key);
    if (!has_prior_ && dataset_.fixed.empty()) hold_the_world();
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

  template <class V>
  FactorId add(const RelativePoseEdge<V>& edge, const Loss& loss) {
    return problem_.graph.add(Between<V>::from_information(edge.measured, edge.information()), {edge.first, edge.second}, loss);
  }
  template <class P>
  FactorId add(const PriorEdge<P>& edge, const Loss&) {
    has_prior_ = true;
    return problem_.graph.add(Prior<P>::from_information(edge.measured, edge.information()), {edge.key});
  }
  template <class P>
  FactorId add(const RelativePointEdge<P>& edge, const Loss& loss) {
    using Pose = std::conditional_t<P::dim == 2, Pose2, Pose3>;
    return problem_.graph.add(RelativePoint<Pose, P>::from_information(edge.measured.value, edge.information()), {edge.pose, edge.landmark},
                              loss);
  }
  FactorId add(const RangeEdge& edge, const Loss& loss) {
    const bool plane = is<Pose2>(edge.first) || is<Point2>(edge.first);
    return plane ? add_range<Pose2, Point2>(edge, loss) : add_range<Pose3, Point3>(edge, loss);
  }
  template <class Pose, class Point>
  FactorId add_range(const RangeEdge& edge, const Loss& loss) {
    if (is<Pose>(edge.first) && is<Pose>(edge.second)) return add_range_of<Pose, Pose>(edge, loss);
    if (is<Pose>(edge.first)) return add_range_of<Pose, Point>(edge, loss);
    if (is<Pose>(edge.second)) return add_range_of<Point, Pose>(edge, loss);
    return add_range_of<Point, Point>(edge, loss);
  }
  template <class A, class B>
  FactorId add_range_of(const RangeEdge& edge, const Loss& loss) {
    return problem_.graph.add(Range<A, B>{edge.distance, std::sqrt(edge.variance)}, {edge.first, edge.second}, loss);
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
  const auto store = [&](Key key, const VertexValue& value) {
    const auto it = known.find(key);
    if (it != known.end())
      it->second->value = value;
    else
      missing.push_back({key, value, {}, {}, 0});
  };
  for (Key key : values.keys()) {
    if (values.contains<Pose2>(key)) store(key, values.at<Pose2>(key));
    if (values.contains<Pose3>(key)) store(key, values.at<Pose3>(key));
    if (values.contains<Point2>(key)) store(key, values.at<Point2>(key));
    if (values.contains<Point3>(key)) store(key, values.at<Point3>(key));
  }
  result.vertices.insert(result.vertices.end(), missing.begin(), missing.end());
  return result;
}

}  // namespace holdfast
