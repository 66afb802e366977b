// PyFG (PyFactorGraph, CORA): g2o's tags with a time stamp, names and covariances.
#include <holdfast/graph/files/internal/formats.hpp>

namespace holdfast::io {
namespace {

template <class V>
constexpr auto vertex = vertex_line<Format::PyFG, V>;
template <class E>
constexpr RecordType edge(std::string_view tag, std::size_t columns, const char* layout, std::size_t other_columns = 0) {
  return edge_line<Format::PyFG, E>(tag, columns, layout, other_columns);
}

constexpr RecordType kLines[] = {
    vertex<Pose2>("VERTEX_SE2", 6, "VERTEX_SE2 time name x y angle"),
    vertex<Pose3>("VERTEX_SE3:QUAT", 10, "VERTEX_SE3:QUAT time name x y z qx qy qz qw"),
    vertex<Point2>("VERTEX_XY", 4, "VERTEX_XY name x y"),
    vertex<Point3>("VERTEX_XYZ", 5, "VERTEX_XYZ name x y z"),
    edge<RangeEdge>("EDGE_RANGE", 6, "EDGE_RANGE time name name distance variance"),
    edge<RelativePoseEdge<Pose2>>("EDGE_SE2", 13, "EDGE_SE2 time name name x y angle, 6 covariances"),
    edge<RelativePoseEdge<Pose3>>("EDGE_SE3:QUAT", 32, "EDGE_SE3:QUAT time name name x y z qx qy qz qw, 21 covariances"),
    edge<RelativePointEdge<Point2>>("EDGE_SE2_XY", 9, "EDGE_SE2_XY time pose landmark x y, 3 covariances"),
    edge<RelativePointEdge<Point3>>("EDGE_SE3_XYZ", 13, "EDGE_SE3_XYZ time pose landmark x y z, 6 covariances"),
    edge<PriorEdge<Pose2>>("VERTEX_SE2:PRIOR", 12, "VERTEX_SE2:PRIOR time name x y angle, 6 covariances"),
    edge<PriorEdge<Pose3>>("VERTEX_SE3:QUAT:PRIOR", 31, "VERTEX_SE3:QUAT:PRIOR time name x y z qx qy qz qw, 21 covariances"),
    edge<PriorEdge<Point2>>("VERTEX_XY:PRIOR", 8, "VERTEX_XY:PRIOR time name x y, 3 covariances"),
    edge<PriorEdge<Point3>>("VERTEX_XYZ:PRIOR", 12, "VERTEX_XYZ:PRIOR time name x y z, 6 covariances"),
};

const char* why_not(Holds holds, std::size_t type) {
  switch (holds) {
    case Holds::sensor_offset:
      return nullptr;  // measurements are in the body's frame: it says nothing more
    case Holds::edge:
      return type == edge_type<BearingEdge>                                                       ? "it has no bearing"
             : type == edge_type<PositionEdge<Point2>> || type == edge_type<PositionEdge<Point3>> ? "it has no prior on a position alone"
                                                                                                  : "it has no step from point to point";
    default:
      return "it has no FIX line; clear `fixed`, or add a prior";
  }
}

}  // namespace

const Dialect& pyfg() {
  static constexpr Dialect dialect{Format::PyFG, std::begin(kLines), std::end(kLines), why_not};
  return dialect;
}

}  // namespace holdfast::io
