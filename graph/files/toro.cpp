// TORO: VERTEX2, EDGE2 in the plane; VERTEX3, EDGE3 with roll, pitch, yaw in space.
#include <holdfast/graph/files/files.hpp>
#include <holdfast/graph/files/internal/formats.hpp>

namespace holdfast {
namespace {

using namespace io;
constexpr Format kFormat = Format::Toro;

template <class V>
Record vertex(Line& line) {
  return read_vertex<V>(line, kFormat, std::nullopt);
}
template <class V>
Record relative_pose(Line& line) {
  return read_relative_pose<V>(line, kFormat, std::nullopt);
}

constexpr RecordType kRecords[] = {
    {"VERTEX2", 5, "VERTEX2 id x y angle", vertex<Pose2>},
    {"VERTEX3", 8, "VERTEX3 id x y z roll pitch yaw", vertex<Pose3>},
    {"EDGE2", 12, "EDGE2 id id x y angle i11 i12 i22 i33 i13 i23", relative_pose<Pose2>},
    {"EDGE3", 30, "EDGE3 id id x y z roll pitch yaw, 21 informations", relative_pose<Pose3>},
};

struct EdgeWriter {
  Text& text;
  const Edge& edge;

  template <class V>
  void operator()(const RelativePoseEdge<V>& e) const {
    text.word(V::space_dim == 2 ? "EDGE2" : "EDGE3");
    write_id(text, e.first, kFormat, describe(edge));
    write_id(text, e.second, kFormat, describe(edge));
    write_value(text, e.measured, e.columns, kFormat);
    write_noise(text, e.noise.converted(kFormat, e.measured));
    text.end_line();
  }
  template <class E>
  void operator()(const E&) const {
    cannot_hold(kFormat, describe(edge), "it has relative poses alone");
  }
};

void write(Text& text, const Vertex& vertex) {
  if (vertex.time) cannot_hold(kFormat, io::describe(vertex), "it has no time stamps; clear them");
  std::visit(
      [&](const auto& value) {
        using V = std::decay_t<decltype(value)>;
        if constexpr (V::dim == V::space_dim) {
          cannot_hold(kFormat, io::describe(vertex), "it has poses alone");
        } else {
          text.word(V::space_dim == 2 ? "VERTEX2" : "VERTEX3");
          write_id(text, vertex.key, kFormat, io::describe(vertex));
          write_value(text, value, vertex.columns, kFormat);
        }
      },
      vertex.value);
  text.end_line();
}

}  // namespace

namespace io {
RecordTable toro_records() { return {std::begin(kRecords), std::end(kRecords)}; }
}  // namespace io

std::string to_toro(const Dataset& dataset) {
  Text text(dataset.symbols);
  if (!dataset.fixed.empty())
    cannot_hold(kFormat, "the fixed variable " + dataset.fixed.front().key.str(), "it has no FIX line; clear `fixed`");
  if (!dataset.offsets.empty()) cannot_hold(kFormat, "a sensor offset", "it has no PARAMS lines; clear `offsets`");
  for (const Vertex& vertex : dataset.vertices) write(text, vertex);
  for (const Edge& edge : dataset.edges) {
    if (edge.time) cannot_hold(kFormat, describe(edge), "it has no time stamps; clear them");
    std::visit(EdgeWriter{text, edge}, edge.measurement);
  }
  write_unknown(text, dataset, kFormat);
  return text.take();
}

}  // namespace holdfast
