#include <Eigen/Eigenvalues>
#include <holdfast/graph/detail/semidefinite.hpp>
#include <holdfast/graph/files/internal/records.hpp>

namespace holdfast::io {
namespace {

/// Files carry 4 digits and more: a larger deviation from norm 1 is no rounding but a mistake (columns shifted, w first).
constexpr double kQuaternionTolerance = 1e-3;

struct Entry {
  int row, column;
};

/// Where the numbers of a matrix stand, in the order of the file.
template <int N>
std::array<Entry, static_cast<std::size_t>(triangle_count(N))> entries(Format format) {
  std::array<Entry, static_cast<std::size_t>(triangle_count(N))> order{};
  std::size_t at = 0;
  for (int row = 0; row < N; ++row)
    for (int column = row; column < N; ++column) order[at++] = {row, column};
  if constexpr (N == 3)
    if (format == Format::Toro) order = {{{0, 0}, {0, 1}, {1, 1}, {2, 2}, {0, 2}, {1, 2}}};
  return order;
}

}  // namespace

template <>
Pose2 decode<Pose2>(const Columns& c) {
  return {c.number[0], c.number[1], c.number[2]};
}
template <>
Pose3 decode<Pose3>(const Columns& c) {
  const std::array<double, 7>& n = c.number;
  if (c.size == 6) return Pose3::from_roll_pitch_yaw({n[0], n[1], n[2]}, n[3], n[4], n[5]);
  return {{n[0], n[1], n[2]}, Pose3::Rotation(n[6], n[3], n[4], n[5]).normalized()};
}
template <>
Point2 decode<Point2>(const Columns& c) {
  return {c.number[0], c.number[1]};
}
template <>
Point3 decode<Point3>(const Columns& c) {
  return {c.number[0], c.number[1], c.number[2]};
}

template <>
Columns encode<Pose2>(const Pose2& pose, Format) {
  return {{pose.p[0], pose.p[1], pose.angle()}, 3};
}
template <>
Columns encode<Pose3>(const Pose3& pose, Format format) {
  if (format == Format::Toro) {
    const Vector<3> angles = pose.roll_pitch_yaw();
    return {{pose.p[0], pose.p[1], pose.p[2], angles[0], angles[1], angles[2]}, 6};
  }
  return {{pose.p[0], pose.p[1], pose.p[2], pose.q.x(), pose.q.y(), pose.q.z(), pose.q.w()}, 7};
}
template <>
Columns encode<Point2>(const Point2& point, Format) {
  return {{point.value[0], point.value[1]}, 2};
}
template <>
Columns encode<Point3>(const Point3& point, Format) {
  return {{point.value[0], point.value[1], point.value[2]}, 3};
}

template <class V>
Columns read_columns(Line& line, Format format) {
  static constexpr std::array<const char*, 7> kQuaternion{"x [m]", "y [m]", "z [m]", "qx", "qy", "qz", "qw"};
  static constexpr std::array<const char*, 6> kRollPitchYaw{"x [m]", "y [m]", "z [m]", "roll [rad]", "pitch [rad]", "yaw [rad]"};
  static constexpr std::array<const char*, 3> kPlane{"x [m]", "y [m]", "angle [rad]"};
  Columns columns;
  columns.size = column_count<V>(format);
  for (std::size_t i = 0; i < static_cast<std::size_t>(columns.size); ++i) {
    const char* what = columns.size == 7 ? kQuaternion[i] : V::space_dim == 3 ? kRollPitchYaw[i] : kPlane[i];
    columns.number[i] = line.next_number(what);
  }
  if (columns.size == 7) {
    const std::array<double, 7>& n = columns.number;
    const double norm = std::sqrt(n[3] * n[3] + n[4] * n[4] + n[5] * n[5] + n[6] * n[6]);
    if (!(std::abs(norm - 1) <= kQuaternionTolerance))
      line.error("the quaternion qx qy qz qw has norm ", to_text(norm), "; expected 1 within ", to_text(kQuaternionTolerance));
  }
  return columns;
}
template Columns read_columns<Pose2>(Line&, Format);
template Columns read_columns<Pose3>(Line&, Format);
template Columns read_columns<Point2>(Line&, Format);
template Columns read_columns<Point3>(Line&, Format);

template <int N>
MatrixNoise<N> read_noise(Line& line, Format format) {
  MatrixNoise<N> noise{Matrix<N, N>::Zero(), format};
  const char* what = noise.is_covariance() ? "a covariance" : "an information";
  for (const Entry& entry : entries<N>(format))
    noise.written(entry.row, entry.column) = noise.written(entry.column, entry.row) = line.next_number(what);
  Matrix<N, N> root;
  const bool usable = noise.written.llt().info() == Eigen::Success ||
                      (!noise.is_covariance() && detail::semidefinite_root(N, noise.written.data(), root.data()));
  if (!usable) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum(noise.written,
                                                                  Eigen::EigenvaluesOnly);  // DontAlign breaks the fixed-size one
    line.error(noise.is_covariance() ? "the covariance" : "the information",
               noise.is_covariance() ? " matrix is not positive definite" : " matrix is not positive semidefinite",
               ": its smallest eigenvalue is ", to_text(spectrum.eigenvalues()[0]), "; expected all ",
               noise.is_covariance() ? "> 0" : ">= 0");
  }
  return noise;
}
template MatrixNoise<2> read_noise<2>(Line&, Format);
template MatrixNoise<3> read_noise<3>(Line&, Format);
template MatrixNoise<6> read_noise<6>(Line&, Format);

Key read_key(Line& line, Format format) { return format == Format::PyFG ? line.next_name() : line.next_id(); }

std::pair<Key, Key> read_keys(Line& line, Format format) {
  const Key first = read_key(line, format);
  const Key second = read_key(line, format);
  if (first == second) line.error("the edge goes from ", first.str(), " to itself; expected two different variables");
  return {first, second};
}

std::optional<double> read_time(Line& line, bool is_there) {
  if (!is_there) return std::nullopt;
  return line.next_number("a time [s]");
}

void read_range(Line& line, Format format, RangeEdge& edge) {
  std::tie(edge.first, edge.second) = read_keys(line, format);
  edge.distance = line.next_number("a distance [m]");
  if (edge.distance < 0) line.error("the distance is ", to_text(edge.distance), "; expected >= 0 [m]");
  edge.variance = line.next_number("a variance [m²]");
  if (!(edge.variance > 0)) line.error("the variance is ", to_text(edge.variance), "; expected > 0 [m²]");
}

std::optional<std::uint64_t> offset_of(const Measurement& measurement) {
  return std::visit(
      [](const auto& edge) -> std::optional<std::uint64_t> {
        if constexpr (HasOffset<std::decay_t<decltype(edge)>>::value) return edge.offset;
        return std::nullopt;
      },
      measurement);
}

void write_columns(Text& text, const Columns& columns) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(columns.size); ++i) text.number(columns.number[i]);
}

template <int N>
void write_noise(Text& text, const MatrixNoise<N>& noise) {
  for (const Entry& entry : entries<N>(noise.format)) text.number(noise.written(entry.row, entry.column));
}
template void write_noise<2>(Text&, const MatrixNoise<2>&);
template void write_noise<3>(Text&, const MatrixNoise<3>&);
template void write_noise<6>(Text&, const MatrixNoise<6>&);

void write_id(Text& text, Key key, Format format, const std::string& record) {
  try {
    text.id(key);
  } catch (const BadKey& error) {
    cannot_hold(format, record, error.what());
  }
}

void write_name(Text& text, Key key, const std::string& record) {
  const std::string name = key.kind() + std::to_string(key.index());  // other programs know no agent numbers
  if (!is_name(name)) cannot_hold(Format::PyFG, record, "its names are a letter and an index; rename " + key.str());
  text.word(name);
}

void write_key(Text& text, Key key, Format format, const std::string& record) {
  format == Format::PyFG ? write_name(text, key, record) : write_id(text, key, format, record);
}

void write_unknown(Text& text, const Dataset& dataset, Format format) {
  for (const UnknownLine& unknown : dataset.unknown) {
    if (dataset.format != format)
      cannot_hold(format, "line " + std::to_string(unknown.line) + " '" + excerpt(unknown.text) + "' of " + dataset.name,
                  "its tag is unknown; clear `unknown` to leave it out");
    text.word(unknown.text);
    text.end_line();
  }
}

void cannot_hold(Format format, const std::string& record, const std::string& why) {
  fail<BadFile>("a ", to_string(format), " file cannot hold ", record, ": ", why);
}

std::string describe(const Vertex& vertex) {
  const char* type = std::visit([](const auto& value) { return std::decay_t<decltype(value)>::name(); }, vertex.value);
  return "vertex " + vertex.key.str() + " (" + type + (vertex.line > 0 ? ", line " + std::to_string(vertex.line) : std::string()) + ")";
}

}  // namespace holdfast::io
