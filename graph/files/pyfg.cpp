// PyFG (PyFactorGraph, CORA): g2o's tags with a time stamp, names and covariances.
#include <holdfast/graph/files/files.hpp>
#include <holdfast/graph/files/internal/formats.hpp>

namespace holdfast {
namespace {

using namespace io;
constexpr Format kFormat = Format::PyFG;

double read_time(Line& line) { return line.next_number("a time [s]"); }

template <class V>
Record pose_vertex(Line& line) {
  const double time = read_time(line);
  return read_vertex<V>(line, kFormat, time);
}
template <class V>
Record point_vertex(Line& line) {
  return read_vertex<V>(line, kFormat, std::nullopt);
}
template <class V>
Record relative_pose(Line& line) {
  const double time = read_time(line);
  return read_relative_pose<V>(line, kFormat, time);
}
template <class P>
Record relative_point(Line& line) {
  const double time = read_time(line);
  return read_relative_point<P>(line, kFormat, time);
}
template <class V>
Record prior(Line& line) {
  const double time = read_time(line);
  return read_prior<V>(line, kFormat, time);
}

Record range(Line& line) {
  const double time = read_time(line);
  const auto [first, second] = read_keys(line, kFormat);
  const double distance = line.next_number("a distance [m]");
  if (distance < 0) line.error("the distance is ", to_text(distance), "; expected >= 0 [m]");
  const double variance = line.next_number("a variance [m²]");
  if (!(variance > 0)) line.error("the variance is ", to_text(variance), "; expected > 0 [m²]");
  return Edge{RangeEdge{first, second, distance, variance}, time, line.number()};
}

constexpr RecordType kRecords[] = {
    {"VERTEX_SE2", 6, "VERTEX_SE2 time name x y angle", pose_vertex<Pose2>},
    {"VERTEX_SE3:QUAT", 10, "VERTEX_SE3:QUAT time name x y z qx qy qz qw", pose_vertex<Pose3>},
    {"VERTEX_XY", 4, "VERTEX_XY name x y", point_vertex<Point2>},
    {"VERTEX_XYZ", 5, "VERTEX_XYZ name x y z", point_vertex<Point3>},
    {"EDGE_RANGE", 6, "EDGE_RANGE time name name distance variance", range},
    {"EDGE_SE2", 13, "EDGE_SE2 time name name x y angle, 6 covariances", relative_pose<Pose2>},
    {"EDGE_SE3:QUAT", 32, "EDGE_SE3:QUAT time name name x y z qx qy qz qw, 21 covariances", relative_pose<Pose3>},
    {"EDGE_SE2_XY", 9, "EDGE_SE2_XY time pose landmark x y, 3 covariances", relative_point<Point2>},
    {"EDGE_SE3_XYZ", 13, "EDGE_SE3_XYZ time pose landmark x y z, 6 covariances", relative_point<Point3>},
    {"VERTEX_SE2:PRIOR", 12, "VERTEX_SE2:PRIOR time name x y angle, 6 covariances", prior<Pose2>},
    {"VERTEX_SE3:QUAT:PRIOR", 31, "VERTEX_SE3:QUAT:PRIOR time name x y z qx qy qz qw, 21 covariances", prior<Pose3>},
    {"VERTEX_XY:PRIOR", 8, "VERTEX_XY:PRIOR time name x y, 3 covariances", prior<Point2>},
    {"VERTEX_XYZ:PRIOR", 12, "VERTEX_XYZ:PRIOR time name x y z, 6 covariances", prior<Point3>},
};

template <class V>
constexpr const char* vertex_tag() {
  if constexpr (std::is_same_v<V, Pose2>) return "VERTEX_SE2";
  if constexpr (std::is_same_v<V, Pose3>) return "VERTEX_SE3:QUAT";
  if constexpr (std::is_same_v<V, Point2>) return "VERTEX_XY";
  return "VERTEX_XYZ";
}

void write_name(Text& text, Key key, const std::string& record) {
  const std::string name = key.kind() + std::to_string(key.index());  // other programs know no agent numbers
  if (!is_name(name)) cannot_hold(kFormat, record, "its names are a letter and an index; rename " + key.str());
  text.word(name);
}

struct EdgeWriter {
  Text& text;
  const Edge& edge;

  void head(std::string_view tag, std::initializer_list<Key> keys) const {
    if (!edge.time) cannot_hold(kFormat, describe(edge), "it has no time stamp; give it one");
    text.word(tag).number(*edge.time);
    for (Key key : keys) write_name(text, key, describe(edge));
  }
  template <class E>
  void tail(const E& e) const {
    write_value(text, e.measured, e.columns, kFormat);
    write_noise(text, e.noise.converted(kFormat, e.measured));
    text.end_line();
  }
  template <class V>
  void operator()(const RelativePoseEdge<V>& e) const {
    head(V::space_dim == 2 ? "EDGE_SE2" : "EDGE_SE3:QUAT", {e.first, e.second});
    tail(e);
  }
  template <class P>
  void operator()(const RelativePointEdge<P>& e) const {
    head(P::dim == 2 ? "EDGE_SE2_XY" : "EDGE_SE3_XYZ", {e.pose, e.landmark});
    tail(e);
  }
  template <class V>
  void operator()(const PriorEdge<V>& e) const {
    head(std::string(vertex_tag<V>()) + ":PRIOR", {e.key});
    tail(e);
  }
  void operator()(const RangeEdge& e) const {
    head("EDGE_RANGE", {e.first, e.second});
    text.number(e.distance).number(e.variance).end_line();
  }
};

void write(Text& text, const Vertex& vertex) {
  std::visit(
      [&](const auto& value) {
        using V = std::decay_t<decltype(value)>;
        constexpr bool is_pose = V::dim > V::space_dim;
        if (is_pose && !vertex.time) cannot_hold(kFormat, io::describe(vertex), "it has no time stamp; give it one");
        if (!is_pose && vertex.time) cannot_hold(kFormat, io::describe(vertex), "its point vertices have no time stamp; clear it");
        text.word(vertex_tag<V>());
        if (is_pose) text.number(*vertex.time);
        write_name(text, vertex.key, io::describe(vertex));
        write_value(text, value, vertex.columns, kFormat);
      },
      vertex.value);
  text.end_line();
}

}  // namespace

namespace io {
RecordTable pyfg_records() { return {std::begin(kRecords), std::end(kRecords)}; }
}  // namespace io

std::string to_pyfg(const Dataset& dataset) {
  Text text;
  if (!dataset.fixed.empty())
    cannot_hold(kFormat, "the fixed variable " + dataset.fixed.front().key.str(), "it has no FIX line; clear `fixed`, or add a prior");
  for (const Vertex& vertex : dataset.vertices) write(text, vertex);
  for (const Edge& edge : dataset.edges) std::visit(EdgeWriter{text, edge}, edge.measurement);
  write_unknown(text, dataset, kFormat);
  return text.take();
}

}  // namespace holdfast
