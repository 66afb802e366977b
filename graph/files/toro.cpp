// TORO: VERTEX2, EDGE2 in the plane; VERTEX3, EDGE3 with roll, pitch, yaw in space. And iSAM's text, whose EDGE2 and EDGE3 are the same
// records: ODOMETRY and LANDMARK, which numbers landmarks apart from poses; and GTSAM's BR.
#include <holdfast/graph/files/internal/formats.hpp>

namespace holdfast::io {
namespace {

template <class V>
constexpr auto vertex = vertex_line<Format::Toro, V>;
template <class E>
constexpr RecordType edge(std::string_view tag, std::size_t columns, const char* layout, std::size_t other_columns = 0) {
  return edge_line<Format::Toro, E>(tag, columns, layout, other_columns);
}

/// iSAM's numbers, row by row, as an information.
template <int N>
MatrixNoise<N> read_isam_noise(Line& line) {
  Matrix<N, N> upper = Matrix<N, N>::Zero();
  for (int row = 0; row < N; ++row)
    for (int column = row; column < N; ++column) upper(row, column) = line.next_number("a number of the noise");
  MatrixNoise<N> noise{upper, Format::Toro};
  switch (line.reading.options.isam_noise) {
    case ReadOptions::IsamNoise::root:
      noise.written = upper.transpose() * upper;
      break;
    case ReadOptions::IsamNoise::information:
      noise.written = upper.template selfadjointView<Eigen::Upper>();
      check_noise(line, noise);
      break;
    case ReadOptions::IsamNoise::covariance:
      MatrixNoise<N> covariance{upper.template selfadjointView<Eigen::Upper>(), Format::PyFG};
      check_noise(line, covariance);
      noise.written = detail::inverse_of_symmetric<N>(covariance.written);
      break;
  }
  if (!noise.written.allFinite()) line.error("its information is not finite; expected numbers whose squares are");
  return noise;
}
Record isam_odometry(Line& line) {
  RelativePoseEdge<Pose2> edge;
  read_keys(line, Format::Toro, edge);
  edge.columns = read_columns<Pose2>(line, Format::Toro);
  edge.measured = decode<Pose2>(edge.columns);
  edge.noise = read_isam_noise<3>(line);
  return Edge{edge, {}, line.number()};
}
Record isam_landmark(Line& line) {
  RelativePointEdge<Point2> edge;
  read_keys(line, Format::Toro, edge);
  edge.columns = read_columns<Point2>(line, Format::Toro);
  edge.measured = decode<Point2>(edge.columns);
  edge.noise = read_isam_noise<2>(line);
  return Edge{edge, {}, line.number()};
}

/// GTSAM's BR: a landmark's bearing and range, with the sigmas of both.
Record bearing_and_range(Line& line) {
  BearingEdge bearing;
  RangeEdge range;
  std::tie(bearing.pose, bearing.landmark) = std::tie(range.first, range.second) = read_keys(line, Format::Toro, true);
  bearing.angle = line.next_number("a bearing [rad]");
  range.distance = line.next_number("a range [m]");
  if (range.distance < 0) line.error("the range is ", to_text(range.distance), "; expected >= 0 [m]");
  const double bearing_sigma = line.next_number("a sigma [rad]"), range_sigma = line.next_number("a sigma [m]");
  bearing.information = 1 / (bearing_sigma * bearing_sigma);
  range.variance = range_sigma * range_sigma;
  if (!(bearing_sigma > 0) || !(range_sigma > 0) || !std::isfinite(bearing.information) || !(range.variance > 0))
    line.error("the sigmas are ", to_text(bearing_sigma), " and ", to_text(range_sigma), "; expected both > 0");
  return std::vector<Edge>{{bearing, {}, line.number()}, {range, {}, line.number()}};
}

constexpr RecordType kLines[] = {
    vertex<Pose2>("VERTEX2", 5, "VERTEX2 id x y angle"),
    vertex<Pose3>("VERTEX3", 8, "VERTEX3 id x y z roll pitch yaw"),
    edge<RelativePoseEdge<Pose2>>("EDGE2", 12, "EDGE2 id id x y angle i11 i12 i22 i33 i13 i23", 6),
    edge<RelativePoseEdge<Pose3>>("EDGE3", 30, "EDGE3 id id x y z roll pitch yaw, 21 informations", 9),
    special_line<RelativePoseEdge<Pose2>>("ODOMETRY", 12, "ODOMETRY id id x y angle, 6 numbers row by row", isam_odometry),
    special_line<RelativePointEdge<Point2>>("LANDMARK", 8, "LANDMARK pose landmark x y, 3 numbers row by row", isam_landmark),
    special_line<BearingEdge>("BR", 7, "BR pose landmark bearing range, 2 sigmas", bearing_and_range),
};

const char* why_not(Holds holds, std::size_t) {
  switch (holds) {
    case Holds::vertex:
      return "it has poses alone; write g2o or PyFG";
    case Holds::edge:
      return "it has relative poses alone";
    case Holds::fixed:
      return "it has no FIX line; clear `fixed`";
    default:
      return "it has no PARAMS lines; clear `offsets`";
  }
}

}  // namespace

const Dialect& toro() {
  static constexpr Dialect dialect{Format::Toro, std::begin(kLines), std::end(kLines), why_not};
  return dialect;
}

}  // namespace holdfast::io
