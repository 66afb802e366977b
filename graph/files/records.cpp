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
std::array<Entry, static_cast<std::size_t>(triangle_count(N))> entries(Format format, bool toro_rows) {
  std::array<Entry, static_cast<std::size_t>(triangle_count(N))> order{};
  std::size_t at = 0;
  for (int row = 0; row < N; ++row)
    for (int column = row; column < N; ++column) order[at++] = {row, column};
  if constexpr (N == 3)
    if (format == Format::Toro && !toro_rows) order = {{{0, 0}, {0, 1}, {1, 1}, {2, 2}, {0, 2}, {1, 2}}};
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

namespace {

template <int N>
void fill(MatrixNoise<N>& noise, const std::array<double, static_cast<std::size_t>(triangle_count(N))>& numbers, bool toro_rows) {
  const auto places = entries<N>(noise.format, toro_rows);
  for (std::size_t i = 0; i < numbers.size(); ++i)
    noise.written(places[i].row, places[i].column) = noise.written(places[i].column, places[i].row) = numbers[i];
}

template <int N>
bool is_usable(const MatrixNoise<N>& noise) {
  Matrix<N, N> root;
  return noise.written.llt().info() == Eigen::Success ||
         (!noise.is_covariance() && detail::semidefinite_root(N, noise.written.data(), root.data()));
}

/// Whether the numbers of a line in TORO's order would be a proper matrix if they stood row by row.
template <int N>
bool is_usable_by_rows(const MatrixNoise<N>& noise) {
  if (N != 3 || noise.format != Format::Toro) return false;
  MatrixNoise<N> rows = noise;
  std::array<double, static_cast<std::size_t>(triangle_count(N))> numbers{};
  const auto places = entries<N>(Format::Toro, false);
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = noise.written(places[i].row, places[i].column);
  fill<N>(rows, numbers, true);
  return is_usable(rows);
}

}  // namespace

template <int N>
void check_noise(Line& line, MatrixNoise<N>& noise) {
  if (is_usable(noise)) return;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum(noise.written);
  const double smallest = spectrum.eigenvalues()[0];
  if (line.reading.options.repair && !noise.is_covariance()) {
    const Eigen::VectorXd kept = spectrum.eigenvalues().cwiseMax(0);
    const Matrix<N, N> nearest = spectrum.eigenvectors() * kept.asDiagonal() * spectrum.eigenvectors().transpose();
    const Matrix<N, N> repaired = 0.5 * (nearest + nearest.transpose());
    line.reading.repair = Repair{line.number(), smallest, (repaired - noise.written).norm() / noise.written.norm()};
    noise.written = repaired;
    return;
  }
  if (noise.is_covariance())
    line.error("the covariance matrix is not positive definite: its smallest eigenvalue is ", to_text(smallest), "; expected all > 0");
  line.error("the information matrix is not positive semidefinite: its smallest eigenvalue is ", to_text(smallest), "; expected all >= 0",
             is_usable_by_rows(noise) ? ": the numbers stand row by row (iSAM, HOG-Man, SLAM++), not in TORO's order 11 12 22 33 13 23? "
                                        "Read it with --toro-order rows (ReadOptions::toro_rows)"
             : noise.format == Format::PyFG
                 ? ""
                 : ": correct it, or take the nearest semidefinite matrix with --indefinite repair (ReadOptions::repair)");
}
template void check_noise<2>(Line&, MatrixNoise<2>&);
template void check_noise<3>(Line&, MatrixNoise<3>&);
template void check_noise<6>(Line&, MatrixNoise<6>&);

template <int N>
MatrixNoise<N> read_noise(Line& line, Format format) {
  MatrixNoise<N> noise{Matrix<N, N>::Identity(), format, format == Format::G2o && line.reading.options.full_angle};
  if (line.at_end()) {
    line.reading.no_noise = true;
    return noise;
  }
  std::array<double, static_cast<std::size_t>(triangle_count(N))> numbers{};
  for (double& number : numbers) number = line.next_number(noise.is_covariance() ? "a covariance" : "an information");
  fill<N>(noise, numbers, line.reading.options.toro_rows);
  check_noise(line, noise);
  return noise;
}
template MatrixNoise<2> read_noise<2>(Line&, Format);
template MatrixNoise<3> read_noise<3>(Line&, Format);
template MatrixNoise<6> read_noise<6>(Line&, Format);

Key read_key(Line& line, Format format) { return format == Format::PyFG ? line.next_name() : line.next_id(); }

Key read_landmark(Line& line, Format format) { return format == Format::PyFG ? line.next_name() : line.next_landmark_id(); }

std::pair<Key, Key> read_keys(Line& line, Format format, bool to_landmark) {
  const Key first = read_key(line, format);
  const Key second = to_landmark ? read_landmark(line, format) : read_key(line, format);
  if (first == second) line.error("the edge goes from ", first.str(), " to itself; expected two different variables");
  return {first, second};
}

std::optional<double> read_time(Line& line, bool is_there) {
  if (!is_there) return std::nullopt;
  return line.next_number("a time [s]");
}

void read_range(Line& line, Format format, RangeEdge& edge) {
  std::tie(edge.first, edge.second) = read_keys(line, format, format != Format::PyFG);
  edge.distance = line.next_number("a distance [m]");
  if (edge.distance < 0) line.error("the distance is ", to_text(edge.distance), "; expected >= 0 [m]");
  if (format == Format::PyFG) {
    edge.variance = line.next_number("a variance [m²]");
    if (!(edge.variance > 0)) line.error("the variance is ", to_text(edge.variance), "; expected > 0 [m²]");
    return;
  }
  edge.information = line.next_number("an information [1/m²]");
  edge.variance = 1 / edge.information;
  if (!(edge.information > 0) || !(edge.variance > 0) || !std::isfinite(edge.variance))
    line.error("the information is ", to_text(edge.information), "; expected > 0 [1/m²] and its inverse finite");
}

void read_bearing(Line& line, Format format, BearingEdge& edge) {
  std::tie(edge.pose, edge.landmark) = read_keys(line, format, true);
  edge.angle = line.next_number("an angle [rad]");
  edge.information = line.next_number("an information [1/rad²]");
  if (!(edge.information > 0)) line.error("the information is ", to_text(edge.information), "; expected > 0 [1/rad²]");
}

// ---- sensors that are not at the body

namespace {

Pose2 mount_of(const SensorOffset& offset, const Pose2*) { return decode<Pose2>(offset.columns); }
Pose3 mount_of(const SensorOffset& offset, const Pose3*) { return offset.T_body_sensor; }
template <class V>
auto mount_of(const SensorOffset& offset) {
  using Pose = std::conditional_t<V::space_dim == 2, Pose2, Pose3>;
  return mount_of(offset, static_cast<const Pose*>(nullptr));
}

/// d(deviation at the sensor) / d(deviation at the body), both as Dataset's noise has them, about zero: with the sensor at (t, R) in the
/// body a turn φ of the body moves it by φ × t.
Matrix<3, 3> deviation_at(const Pose2& sensor) {
  Matrix<3, 3> J = Matrix<3, 3>::Identity();
  J.topLeftCorner<2, 2>() = sensor.rotation().transpose();
  J.topRightCorner<2, 1>() = sensor.rotation().transpose() * Vector<2>(-sensor.p[1], sensor.p[0]);
  return J;
}
Matrix<6, 6> deviation_at(const Pose3& sensor) {
  const Matrix<3, 3> R_t = sensor.rotation().transpose();
  Matrix<3, 3> cross;
  cross << 0, -sensor.p[2], sensor.p[1], sensor.p[2], 0, -sensor.p[0], -sensor.p[1], sensor.p[0], 0;
  Matrix<6, 6> J = Matrix<6, 6>::Zero();
  J.topLeftCorner<3, 3>() = R_t;
  J.topRightCorner<3, 3>() = -R_t * cross;
  J.bottomRightCorner<3, 3>() = R_t;
  return J;
}

/// Informations of `at_sensor` as those of `in_body`.
template <class V>
MatrixNoise<V::dim> moved(const MatrixNoise<V::dim>& noise, const V& at_sensor, const V& in_body, const V& sensor) {
  const Matrix<V::dim, V::dim> information = detail::congruence<V::dim>(deviation_at(sensor), noise.information(at_sensor));
  MatrixNoise<V::dim> result = MatrixNoise<V::dim>::of_information(information, noise.format, in_body);
  if (noise.full_angle) result.written = information;
  result.full_angle = noise.full_angle;
  return result;
}

template <class E>
void mount_one(E&, const std::vector<const SensorOffset*>&) {}
template <class P>
void mount_one(RelativePointEdge<P>& edge, const std::vector<const SensorOffset*>& offsets) {
  const auto sensor = mount_of<P>(*offsets[0]);
  edge.measured = P((sensor.p + sensor.to_world(edge.measured.value)).eval());
  edge.noise.written = detail::congruence<P::dim>(sensor.rotation().transpose(), edge.noise.written);
  edge.columns = {};
  edge.offset.reset();
}
template <class V>
std::enable_if_t<(V::dim > V::space_dim)> mount_one(PriorEdge<V>& edge, const std::vector<const SensorOffset*>& offsets) {
  const V sensor = mount_of<V>(*offsets[0]);
  const V in_body = edge.measured * sensor.inverse();
  edge.noise = moved(edge.noise, edge.measured, in_body, sensor);
  edge.measured = in_body;
  edge.columns = {};
  edge.offset.reset();
}
template <class V>
std::enable_if_t<(V::dim > V::space_dim)> mount_one(RelativePoseEdge<V>& edge, const std::vector<const SensorOffset*>& offsets) {
  const V first = mount_of<V>(*offsets[0]), second = mount_of<V>(*offsets[1]);
  const V in_body = first * edge.measured * second.inverse();
  edge.noise = moved(edge.noise, edge.measured, in_body, second);
  edge.measured = in_body;
  edge.columns = {};
}

template <class T>
bool same_bits(const T& a, const T& b) {
  return std::memcmp(static_cast<const void*>(&a), static_cast<const void*>(&b), sizeof(T)) == 0;
}
bool is_same(const RangeEdge& a, const RangeEdge& b) {
  return a.first == b.first && a.second == b.second && same_bits(a.distance, b.distance) && same_bits(a.variance, b.variance);
}
bool is_same(const BearingEdge& a, const BearingEdge& b) {
  return a.pose == b.pose && a.landmark == b.landmark && same_bits(a.angle, b.angle) && same_bits(a.information, b.information);
}
template <class E>
bool is_same(const E& a, const E& b) {
  return keys_of(Measurement(a)) == keys_of(Measurement(b)) && same_bits(a.measured, b.measured) &&
         same_bits(a.noise.written, b.noise.written) && a.noise.format == b.noise.format;
}

}  // namespace

void mount(Measurement& measurement, const std::vector<const SensorOffset*>& offsets) {
  std::visit([&](auto& edge) { mount_one(edge, offsets); }, measurement);
}

bool is_same(const Measurement& a, const Measurement& b) {
  if (a.index() != b.index()) return false;
  return std::visit([&](const auto& x) { return is_same(x, std::get<std::decay_t<decltype(x)>>(b)); }, a);
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
void write_noise(Text& text, const MatrixNoise<N>& noise, bool toro_rows) {
  for (const Entry& entry : entries<N>(noise.format, toro_rows)) text.number(noise.written(entry.row, entry.column));
}
template void write_noise<2>(Text&, const MatrixNoise<2>&, bool);
template void write_noise<3>(Text&, const MatrixNoise<3>&, bool);
template void write_noise<6>(Text&, const MatrixNoise<6>&, bool);

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

void cannot_hold(Format format, const std::string& record, const std::string& why) {
  fail<BadFile>("a ", to_string(format), " file cannot hold ", record, ": ", why);
}

std::string describe(const Vertex& vertex) {
  const char* type = std::visit([](const auto& value) { return std::decay_t<decltype(value)>::name(); }, vertex.value);
  return "vertex " + vertex.key.str() + " (" + type + (vertex.line > 0 ? ", line " + std::to_string(vertex.line) : std::string()) + ")";
}

}  // namespace holdfast::io
