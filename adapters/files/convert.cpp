#include <algorithm>
#include <holdfast/adapters/files/convert.hpp>
#include <holdfast/adapters/files/problem.hpp>
#include <holdfast/graph/files/jrl.hpp>
#include <holdfast/graph/starts/start.hpp>
#include <map>

namespace holdfast {
namespace {

constexpr double kFixedSigma = 1e-4;  // [m], [rad]

std::string counted(std::size_t n, const char* one, const char* many) { return std::to_string(n) + ' ' + (n == 1 ? one : many); }

bool is_pose(const VertexValue& value) { return std::holds_alternative<Pose2>(value) || std::holds_alternative<Pose3>(value); }

class Converter {
 public:
  Converter(const Dataset& dataset, Format format) : format_(format) { result_.dataset = dataset; }

  Conversion convert() {
    Dataset& dataset = result_.dataset;
    leave_out_unknown();
    if (dataset.format == format_ && format_ != Format::PyFG) return std::move(result_);
    if (format_ == Format::PyFG) {
      complete();
      add_times();
      fixed_to_priors();
    } else {
      clear_times();
      if (format_ == Format::Toro) clear_fixed();
    }
    if (format_ != Format::G2o) leave_out_offsets();
    return std::move(result_);
  }

 private:
  void note(const std::string& text) { result_.notes.push_back(text); }

  void leave_out_unknown() {
    Dataset& dataset = result_.dataset;
    Dataset left_out;
    left_out.name = dataset.name;
    for (const UnknownLine& line : dataset.unknown)
      if (dataset.format != format_ || is_of_jrl(line)) left_out.unknown.push_back(line);
    if (left_out.unknown.empty()) return;
    note(unknown_report(left_out));
    dataset.unknown.erase(std::remove_if(dataset.unknown.begin(), dataset.unknown.end(),
                                         [&](const UnknownLine& line) { return dataset.format != format_ || is_of_jrl(line); }),
                          dataset.unknown.end());
  }
  void leave_out_offsets() {
    for (Edge& edge : result_.dataset.edges)
      std::visit(
          [](auto& one) {
            using E = std::decay_t<decltype(one)>;
            if constexpr (!std::is_same_v<E, RangeEdge> && !std::is_same_v<E, BearingEdge>) clear_offset(one);
          },
          edge.measurement);
    result_.dataset.offsets.clear();  // measurements are in the body's frame
  }
  template <class E>
  static void clear_offset(E&) {}
  template <class P>
  static void clear_offset(RelativePointEdge<P>& edge) {
    edge.offset.reset();
  }
  template <class V>
  static void clear_offset(PriorEdge<V>& edge) {
    edge.offset.reset();
  }

  void clear_times() {
    std::size_t count = 0;
    for (Vertex& vertex : result_.dataset.vertices) count += vertex.time.has_value(), vertex.time.reset();
    for (Edge& edge : result_.dataset.edges) count += edge.time.has_value(), edge.time.reset();
    if (count > 0) note(counted(count, "time stamp", "time stamps") + " left out: " + to_string(format_) + " has none");
  }
  void clear_fixed() {
    if (result_.dataset.fixed.empty()) return;
    note(counted(result_.dataset.fixed.size(), "fixed variable", "fixed variables") + " left out: TORO has no FIX line");
    result_.dataset.fixed.clear();
  }

  void complete() {
    const std::size_t before = result_.dataset.vertices.size();
    result_.dataset = with_values(result_.dataset, vertex_start(result_.dataset));
    if (const std::size_t added = result_.dataset.vertices.size() - before)
      note(counted(added, "vertex", "vertices") + " added where the edges put them: PyFG needs one for every name");
  }
  void add_times() {
    std::size_t count = 0;
    std::map<Key, double> times;
    for (Vertex& vertex : result_.dataset.vertices) {
      if (!is_pose(vertex.value)) continue;
      if (!vertex.time) {
        vertex.time = static_cast<double>(vertex.key.step());
        ++count;
      }
      times[vertex.key] = *vertex.time;
    }
    for (Edge& edge : result_.dataset.edges) {
      if (edge.time) continue;
      double latest = 0;
      for (Key key : keys_of(edge.measurement))
        if (const auto it = times.find(key); it != times.end()) latest = std::max(latest, it->second);
      edge.time = latest;
      ++count;
    }
    if (count > 0) note(counted(count, "time stamp", "time stamps") + " made of the steps: PyFG needs one for every pose and edge");
  }
  void fixed_to_priors() {
    Dataset& dataset = result_.dataset;
    if (dataset.fixed.empty()) return;
    std::map<Key, const Vertex*> vertices;
    for (const Vertex& vertex : dataset.vertices) vertices[vertex.key] = &vertex;
    std::size_t count = 0;
    std::vector<Edge> priors;
    for (const Fixed& fixed : dataset.fixed) {
      const auto it = vertices.find(fixed.key);
      if (it == vertices.end()) continue;
      const double time = it->second->time.value_or(0);
      std::visit([&](const auto& value) { priors.push_back({prior_at(fixed.key, value), time, 0}); }, it->second->value);
      ++count;
      vertices.erase(it);
    }
    dataset.edges.insert(dataset.edges.end(), priors.begin(), priors.end());
    note(counted(count, "fixed variable", "fixed variables") + " written as priors with a sigma of 1e-4 m and rad: PyFG has no FIX line");
    dataset.fixed.clear();
  }
  template <class V>
  static Measurement prior_at(Key key, const V& value) {
    const Matrix<V::dim, V::dim> covariance = kFixedSigma * kFixedSigma * Matrix<V::dim, V::dim>::Identity();
    return PriorEdge<V>{key, value, {}, {covariance, Format::PyFG}};
  }

  Format format_;
  Conversion result_;
};

}  // namespace

Conversion converted(const Dataset& dataset, Format format) { return Converter(dataset, format).convert(); }

std::optional<Format> format_of_name(const std::string& path) {
  const std::size_t dot = path.find_last_of('.');
  if (dot == std::string::npos) return std::nullopt;
  const std::string ending = path.substr(dot + 1);
  if (ending == "g2o") return Format::G2o;
  if (ending == "pyfg") return Format::PyFG;
  if (ending == "graph" || ending == "toro") return Format::Toro;
  return std::nullopt;
}

}  // namespace holdfast
