// g2o: integer ids, no time stamps, information matrices.
#include <holdfast/graph/files/internal/formats.hpp>

namespace holdfast::io {
namespace {

template <class V>
constexpr auto vertex = vertex_line<Format::G2o, V>;
template <class E>
constexpr auto edge = edge_line<Format::G2o, E>;
template <class E>
constexpr auto edge_with_offset = edge_line<Format::G2o, E, true>;

Record fix(Line& line) {
  std::vector<Fixed> fixed;
  while (!line.at_end()) fixed.push_back({read_key(line, Format::G2o), line.number()});
  return fixed;
}

Record sensor_offset(Line& line) {
  const std::uint64_t id = line.next_index("the id of a sensor offset");
  const Columns columns = read_columns<Pose3>(line, Format::G2o);
  return SensorOffset{id, decode<Pose3>(columns), columns, line.number()};
}

constexpr RecordType kLines[] = {
    vertex<Pose2>("VERTEX_SE2", 5, "VERTEX_SE2 id x y angle"),
    vertex<Pose3>("VERTEX_SE3:QUAT", 9, "VERTEX_SE3:QUAT id x y z qx qy qz qw"),
    vertex<Point2>("VERTEX_XY", 4, "VERTEX_XY id x y"),
    vertex<Point3>("VERTEX_TRACKXYZ", 5, "VERTEX_TRACKXYZ id x y z"),
    edge<RelativePoseEdge<Pose2>>("EDGE_SE2", 12, "EDGE_SE2 id id x y angle, 6 informations"),
    edge<RelativePoseEdge<Pose3>>("EDGE_SE3:QUAT", 31, "EDGE_SE3:QUAT id id x y z qx qy qz qw, 21 informations"),
    edge<RelativePointEdge<Point2>>("EDGE_SE2_XY", 8, "EDGE_SE2_XY pose landmark x y, 3 informations"),
    edge_with_offset<RelativePointEdge<Point3>>("EDGE_SE3_TRACKXYZ", 13, "EDGE_SE3_TRACKXYZ pose landmark offset x y z, 6 informations"),
    edge<PriorEdge<Pose2>>("EDGE_PRIOR_SE2", 11, "EDGE_PRIOR_SE2 id x y angle, 6 informations"),
    edge<PriorEdge<Pose3>>("EDGE_PRIOR_SE3", 30, "EDGE_PRIOR_SE3 id x y z qx qy qz qw, 21 informations"),
    edge_with_offset<PriorEdge<Pose3>>("EDGE_SE3_PRIOR", 31, "EDGE_SE3_PRIOR id offset x y z qx qy qz qw, 21 informations"),
    {"PARAMS_SE3OFFSET", 9, "PARAMS_SE3OFFSET id x y z qx qy qz qw", sensor_offset, Holds::sensor_offset},
    {"FIX", 0, "FIX id …", fix, Holds::fixed},
};

const char* why_not(Holds, std::size_t type) {
  switch (type) {
    case edge_type<RangeEdge>:
      return "it has no range edge; write PyFG";
    case edge_type<RelativePointEdge<Point3>>:
      return "EDGE_SE3_TRACKXYZ needs a sensor offset; add the identity to `offsets` and name it";
    case edge_type<PriorEdge<Point2>>:
    case edge_type<PriorEdge<Point3>>:
      return "it has no prior on a point";
    default:
      return "in the plane its lines name no sensor offset; clear it";
  }
}

}  // namespace

const Dialect& g2o() {
  static constexpr Dialect dialect{Format::G2o, std::begin(kLines), std::end(kLines), why_not};
  return dialect;
}

}  // namespace holdfast::io
