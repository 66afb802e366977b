// g2o: integer ids, no time stamps, information matrices.
#include <holdfast/graph/files/files.hpp>
#include <holdfast/graph/files/internal/formats.hpp>

namespace holdfast {
namespace {

using namespace io;
constexpr Format kFormat = Format::G2o;
constexpr bool kWithOffset = true;

template <class V>
Record vertex(Line& line) {
  return read_vertex<V>(line, kFormat, std::nullopt);
}
template <class V>
Record relative_pose(Line& line) {
  return read_relative_pose<V>(line, kFormat, std::nullopt);
}
template <class P>
Record relative_point(Line& line) {
  return read_relative_point<P>(line, kFormat, std::nullopt, P::dim == 3 ? kWithOffset : !kWithOffset);
}
template <class V>
Record prior(Line& line) {
  return read_prior<V>(line, kFormat, std::nullopt);
}
Record prior_with_offset(Line& line) { return read_prior<Pose3>(line, kFormat, std::nullopt, kWithOffset); }

Record fix(Line& line) {
  std::vector<Fixed> fixed;
  while (!line.at_end()) fixed.push_back({line.next_id(), line.number()});
  return fixed;
}

Record sensor_offset(Line& line) {
  const std::uint64_t id = line.next_index("the id of a sensor offset");
  const Columns columns = read_columns<Pose3>(line, kFormat);
  return SensorOffset{id, decode<Pose3>(columns), columns, line.number()};
}

constexpr RecordType kRecords[] = {
    {"VERTEX_SE2", 5, "VERTEX_SE2 id x y angle", vertex<Pose2>},
    {"VERTEX_SE3:QUAT", 9, "VERTEX_SE3:QUAT id x y z qx qy qz qw", vertex<Pose3>},
    {"VERTEX_XY", 4, "VERTEX_XY id x y", vertex<Point2>},
    {"VERTEX_TRACKXYZ", 5, "VERTEX_TRACKXYZ id x y z", vertex<Point3>},
    {"EDGE_SE2", 12, "EDGE_SE2 id id x y angle, 6 informations", relative_pose<Pose2>},
    {"EDGE_SE3:QUAT", 31, "EDGE_SE3:QUAT id id x y z qx qy qz qw, 21 informations", relative_pose<Pose3>},
    {"EDGE_SE2_XY", 8, "EDGE_SE2_XY pose landmark x y, 3 informations", relative_point<Point2>},
    {"EDGE_SE3_TRACKXYZ", 13, "EDGE_SE3_TRACKXYZ pose landmark offset x y z, 6 informations", relative_point<Point3>},
    {"EDGE_PRIOR_SE2", 11, "EDGE_PRIOR_SE2 id x y angle, 6 informations", prior<Pose2>},
    {"EDGE_PRIOR_SE3", 30, "EDGE_PRIOR_SE3 id x y z qx qy qz qw, 21 informations", prior<Pose3>},
    {"EDGE_SE3_PRIOR", 31, "EDGE_SE3_PRIOR id offset x y z qx qy qz qw, 21 informations", prior_with_offset},
    {"PARAMS_SE3OFFSET", 9, "PARAMS_SE3OFFSET id x y z qx qy qz qw", sensor_offset},
    {"FIX", 0, "FIX id …", fix},
};

template <class V>
constexpr const char* vertex_tag() {
  if constexpr (std::is_same_v<V, Pose2>) return "VERTEX_SE2";
  if constexpr (std::is_same_v<V, Pose3>) return "VERTEX_SE3:QUAT";
  if constexpr (std::is_same_v<V, Point2>) return "VERTEX_XY";
  return "VERTEX_TRACKXYZ";
}

struct EdgeWriter {
  Text& text;
  const Edge& edge;

  void head(std::string_view tag, std::initializer_list<Key> keys) const {
    text.word(tag);
    for (Key key : keys) write_id(text, key, kFormat, describe(edge));
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
    head(P::dim == 2 ? "EDGE_SE2_XY" : "EDGE_SE3_TRACKXYZ", {e.pose, e.landmark});
    if constexpr (P::dim == 3) {
      if (!e.offset)
        cannot_hold(kFormat, describe(edge), "EDGE_SE3_TRACKXYZ needs a sensor offset; add the identity to `offsets` and name it");
      text.word(std::to_string(*e.offset));
    }
    tail(e);
  }
  template <class V>
  void operator()(const PriorEdge<V>& e) const {
    if constexpr (V::dim == V::space_dim) {
      cannot_hold(kFormat, describe(edge), "it has no prior on a point");
    } else {
      head(V::space_dim == 2 ? "EDGE_PRIOR_SE2" : e.offset ? "EDGE_SE3_PRIOR" : "EDGE_PRIOR_SE3", {e.key});
      if (e.offset) text.word(std::to_string(*e.offset));
      tail(e);
    }
  }
  void operator()(const RangeEdge&) const { cannot_hold(kFormat, describe(edge), "it has no range edge; write PyFG"); }
};

void write(Text& text, const Vertex& vertex) {
  if (vertex.time) cannot_hold(kFormat, io::describe(vertex), "it has no time stamps; clear them");
  std::visit(
      [&](const auto& value) {
        text.word(vertex_tag<std::decay_t<decltype(value)>>());
        write_id(text, vertex.key, kFormat, io::describe(vertex));
        write_value(text, value, vertex.columns, kFormat);
      },
      vertex.value);
  text.end_line();
}

}  // namespace

namespace io {
RecordTable g2o_records() { return {std::begin(kRecords), std::end(kRecords)}; }
}  // namespace io

std::string to_g2o(const Dataset& dataset) {
  Text text(dataset.symbols);
  for (const SensorOffset& offset : dataset.offsets) {
    text.word("PARAMS_SE3OFFSET").word(std::to_string(offset.id));
    write_value(text, offset.T_body_sensor, offset.columns, kFormat);
    text.end_line();
  }
  for (const Vertex& vertex : dataset.vertices) write(text, vertex);
  for (const Fixed& fixed : dataset.fixed) {
    text.word("FIX");
    write_id(text, fixed.key, kFormat, "the fixed variable " + fixed.key.str());
    text.end_line();
  }
  for (const Edge& edge : dataset.edges) {
    if (edge.time) cannot_hold(kFormat, describe(edge), "it has no time stamps; clear them");
    std::visit(EdgeWriter{text, edge}, edge.measurement);
  }
  write_unknown(text, dataset, kFormat);
  return text.take();
}

}  // namespace holdfast
