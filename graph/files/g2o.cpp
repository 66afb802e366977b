// g2o: integer ids, no time stamps, information matrices.
#include <holdfast/graph/files/internal/formats.hpp>

namespace holdfast::io {
namespace {

template <class V>
constexpr auto vertex = vertex_line<Format::G2o, V>;
template <class E>
constexpr RecordType edge(std::string_view tag, std::size_t columns, const char* layout, std::size_t other_columns = 0) {
  return edge_line<Format::G2o, E>(tag, columns, layout, other_columns);
}
template <class E>
constexpr RecordType edge_with_offset(std::string_view tag, std::size_t columns, const char* layout, std::size_t other_columns = 0) {
  return edge_line<Format::G2o, E, true>(tag, columns, layout, other_columns);
}

Record fix(Line& line) {
  std::vector<Fixed> fixed;
  while (!line.at_end()) fixed.push_back({read_key(line, Format::G2o), line.number()});
  return fixed;
}

Record sensor_offset(Line& line) {
  const std::uint64_t id = line.next_index("the id of a sensor offset");
  const Columns columns = read_columns<Pose3>(line, Format::G2o);
  return SensorOffset{id, decode<Pose3>(columns), columns, line.number(), false};
}
Record sensor_offset_in_plane(Line& line) {
  const std::uint64_t id = line.next_index("the id of a sensor offset");
  const Columns columns = read_columns<Pose2>(line, Format::G2o);
  const double half = 0.5 * columns.number[2];
  const Pose3 in_space{{columns.number[0], columns.number[1], 0}, Pose3::Rotation(std::cos(half), 0, 0, std::sin(half))};
  return SensorOffset{id, in_space, columns, line.number(), true};
}

void name_offset(Line& line) { line.reading.offsets.push_back(line.next_index("the id of a sensor offset")); }

/// EDGE_SE2_OFFSET: from one sensor to another.
template <class V>
Record between_sensors(Line& line) {
  RelativePoseEdge<V> edge;
  read_keys(line, Format::G2o, edge);
  name_offset(line);
  name_offset(line);
  read_numbers(line, Format::G2o, edge);
  return Edge{edge, {}, line.number()};
}
/// EDGE_SE2_POINTXY_OFFSET.
Record point_from_sensor(Line& line) {
  RelativePointEdge<Point2> edge;
  read_keys(line, Format::G2o, edge);
  name_offset(line);
  read_numbers(line, Format::G2o, edge);
  return Edge{edge, {}, line.number()};
}
/// Vertigo: a relative pose with a switch (an id) or the weight of a mixture before its numbers, which a loss stands for here.
template <class V>
Record switched(Line& line) {
  RelativePoseEdge<V> edge;
  read_keys(line, Format::G2o, edge);
  line.next_index("the id of a switch");
  read_numbers(line, Format::G2o, edge);
  return Edge{edge, {}, line.number()};
}
template <class V>
Record mixed(Line& line) {
  RelativePoseEdge<V> edge;
  read_keys(line, Format::G2o, edge);
  const double weight = line.next_number("the weight of the null hypothesis");
  if (!(weight > 0)) line.error("the weight is ", to_text(weight), "; expected > 0");
  read_numbers(line, Format::G2o, edge);
  return Edge{edge, {}, line.number()};
}
/// EDGE_SE3_XYZ_PRIOR names an offset that its error does not use (g2o); other programs leave it out.
Record position_with_parameter(Line& line) {
  PositionEdge<Point3> edge;
  read_keys(line, Format::G2o, edge);
  if (line.size() == 12) line.next_index("the id of a sensor offset");
  read_numbers(line, Format::G2o, edge);
  return Edge{edge, {}, line.number()};
}
/// hdl_graph_slam's EDGE_SE3_PRIORXY: nothing is known of the height.
Record horizontal_position(Line& line) {
  PositionEdge<Point3> edge;
  read_keys(line, Format::G2o, edge);
  edge.measured = Point3(line.next_number("x [m]"), line.next_number("y [m]"), 0);
  const MatrixNoise<2> noise = read_noise<2>(line, Format::G2o);
  edge.noise = {Matrix<3, 3>::Zero(), Format::G2o};
  edge.noise.written.topLeftCorner<2, 2>() = noise.written;
  return Edge{edge, {}, line.number()};
}
/// hdl_graph_slam's EDGE_SE3_PRIORQUAT, w first: the error is vec(q) − vec(measured), which for q = measured · (1, v) is
/// (w I + [vec(measured)]×) v.
Record rotation(Line& line) {
  PriorEdge<Pose3> edge;
  read_keys(line, Format::G2o, edge);
  const double w = line.next_number("qw"), x = line.next_number("qx"), y = line.next_number("qy"), z = line.next_number("qz");
  const double norm = std::sqrt(w * w + x * x + y * y + z * z);
  if (!(std::abs(norm - 1) <= 1e-3)) line.error("the quaternion qw qx qy qz has norm ", to_text(norm), "; expected 1 within 0.001");
  edge.measured.q = Pose3::Rotation(w, x, y, z).normalized();
  const Matrix<3, 3> information = read_noise<3>(line, Format::G2o).written;
  Matrix<3, 3> J;
  J << w, -z, y, z, w, -x, -y, x, w;
  edge.noise = {Matrix<6, 6>::Zero(), Format::G2o};
  edge.noise.written.bottomRightCorner<3, 3>() = detail::congruence<3>(J, information);
  return Edge{edge, {}, line.number()};
}

template <class E>
constexpr RecordType alias(std::string_view tag, std::size_t columns, const char* layout) {
  return edge_line<Format::G2o, E, false, true>(tag, columns, layout);
}

// The first row of a kind is what the writer takes.
constexpr RecordType kLines[] = {
    vertex<Pose2>("VERTEX_SE2", 5, "VERTEX_SE2 id x y angle"),
    vertex<Pose3>("VERTEX_SE3:QUAT", 9, "VERTEX_SE3:QUAT id x y z qx qy qz qw"),
    vertex<Point2>("VERTEX_XY", 4, "VERTEX_XY id x y"),
    vertex<Point3>("VERTEX_TRACKXYZ", 5, "VERTEX_TRACKXYZ id x y z"),
    edge<RelativePoseEdge<Pose2>>("EDGE_SE2", 12, "EDGE_SE2 id id x y angle, 6 informations", 6),
    edge<RelativePoseEdge<Pose3>>("EDGE_SE3:QUAT", 31, "EDGE_SE3:QUAT id id x y z qx qy qz qw, 21 informations", 10),
    edge<RelativePointEdge<Point2>>("EDGE_SE2_XY", 8, "EDGE_SE2_XY pose landmark x y, 3 informations", 5),
    edge_with_offset<RelativePointEdge<Point3>>("EDGE_SE3_TRACKXYZ", 13, "EDGE_SE3_TRACKXYZ pose landmark offset x y z, 6 informations", 7),
    edge<PriorEdge<Pose2>>("EDGE_PRIOR_SE2", 11, "EDGE_PRIOR_SE2 id x y angle, 6 informations"),
    edge<PriorEdge<Pose3>>("EDGE_PRIOR_SE3", 30, "EDGE_PRIOR_SE3 id x y z qx qy qz qw, 21 informations"),
    edge_with_offset<PriorEdge<Pose3>>("EDGE_SE3_PRIOR", 31, "EDGE_SE3_PRIOR id offset x y z qx qy qz qw, 21 informations"),
    {"PARAMS_SE3OFFSET", 9, "PARAMS_SE3OFFSET id x y z qx qy qz qw", sensor_offset, Holds::sensor_offset},
    {"PARAMS_SE2OFFSET", 5, "PARAMS_SE2OFFSET id x y angle", sensor_offset_in_plane, Holds::sensor_offset, 1},
    {"FIX", 0, "FIX id …", fix, Holds::fixed},
    edge<PositionEdge<Point2>>("EDGE_PRIOR_SE2_XY", 7, "EDGE_PRIOR_SE2_XY id x y, 3 informations"),
    edge<PositionEdge<Point3>>("EDGE_SE3_PRIORXYZ", 11, "EDGE_SE3_PRIORXYZ id x y z, 6 informations"),
    edge<PriorEdge<Point2>>("EDGE_PRIOR_XY", 7, "EDGE_PRIOR_XY landmark x y, 3 informations"),
    edge<PriorEdge<Point3>>("EDGE_POINTXYZ_PRIOR", 11, "EDGE_POINTXYZ_PRIOR landmark x y z, 6 informations"),
    edge<RelativePoseEdge<Point2>>("EDGE_POINTXY", 8, "EDGE_POINTXY id id x y, 3 informations"),
    edge<RelativePoseEdge<Point3>>("EDGE_POINTXYZ", 12, "EDGE_POINTXYZ id id x y z, 6 informations"),
    edge<BearingEdge>("EDGE_BEARING_SE2_XY", 5, "EDGE_BEARING_SE2_XY pose landmark angle information"),
    edge<RangeEdge>("EDGE_RANGE_SE2_XY", 5, "EDGE_RANGE_SE2_XY pose landmark distance information"),
    // other names
    alias<PriorEdge<Pose2>>("EDGE_SE2_PRIOR", 11, "EDGE_SE2_PRIOR id x y angle, 6 informations"),
    alias<PositionEdge<Point2>>("EDGE_SE2_XY_PRIOR", 7, "EDGE_SE2_XY_PRIOR id x y, 3 informations"),
    alias<PositionEdge<Point2>>("EDGE_SE2_PRIORXY", 7, "EDGE_SE2_PRIORXY id x y, 3 informations"),
    alias<PriorEdge<Point2>>("EDGE_XY_PRIOR", 7, "EDGE_XY_PRIOR landmark x y, 3 informations"),
    alias<PriorEdge<Point3>>("EDGE_XYZ_PRIOR", 11, "EDGE_XYZ_PRIOR landmark x y z, 6 informations"),
    alias<PriorEdge<Point3>>("EDGE_PRIOR_XYZ", 11, "EDGE_PRIOR_XYZ landmark x y z, 6 informations"),
    // lines that say more
    special_line<PositionEdge<Point3>>("EDGE_SE3_XYZ_PRIOR", 12, "EDGE_SE3_XYZ_PRIOR id offset x y z, 6 informations",
                                       position_with_parameter, 11),
    special_line<PositionEdge<Point3>>("EDGE_SE3_PRIORXY", 7, "EDGE_SE3_PRIORXY id x y, 3 informations", horizontal_position),
    special_line<PriorEdge<Pose3>>("EDGE_SE3_PRIORQUAT", 12, "EDGE_SE3_PRIORQUAT id qw qx qy qz, 6 informations", rotation),
    special_line<RelativePoseEdge<Pose2>>("EDGE_SE2_OFFSET", 14, "EDGE_SE2_OFFSET id id offset offset x y angle, 6 informations",
                                          between_sensors<Pose2>, 8),
    special_line<RelativePoseEdge<Pose3>>("EDGE_SE3_OFFSET", 33, "EDGE_SE3_OFFSET id id offset offset x y z qx qy qz qw, 21 informations",
                                          between_sensors<Pose3>, 12),
    special_line<RelativePointEdge<Point2>>("EDGE_SE2_POINTXY_OFFSET", 9,
                                            "EDGE_SE2_POINTXY_OFFSET pose landmark offset x y, 3 informations", point_from_sensor, 6),
    special_line<RelativePoseEdge<Pose2>>("EDGE_SE2_SWITCHABLE", 13, "EDGE_SE2_SWITCHABLE id id switch x y angle, 6 informations",
                                          switched<Pose2>, 7),
    special_line<RelativePoseEdge<Pose3>>("EDGE_SE3_SWITCHABLE", 32, "EDGE_SE3_SWITCHABLE id id switch x y z qx qy qz qw, 21 informations",
                                          switched<Pose3>, 11),
    special_line<RelativePoseEdge<Pose2>>("EDGE_SE2_MAXMIX", 13, "EDGE_SE2_MAXMIX id id weight x y angle, 6 informations", mixed<Pose2>, 7),
    special_line<RelativePoseEdge<Pose3>>("EDGE_SE3_MAXMIX", 32, "EDGE_SE3_MAXMIX id id weight x y z qx qy qz qw, 21 informations",
                                          mixed<Pose3>, 11),
};

const char* why_not(Holds, std::size_t type) {
  switch (type) {
    case edge_type<RangeEdge>:
      return "it has ranges from a pose in the plane to a landmark alone; write PyFG";
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
