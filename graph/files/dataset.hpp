// A file of measurements, read but not yet interpreted: what every reader makes and every writer takes.
//
// A Dataset is lossless. Beside each value it keeps the columns of the file (an angle, not its cosine; the quaternion before it
// was normalised) and the noise matrix as written, so file → Dataset → file gives every number back bit by bit.
// The columns are a memory, not a second truth: a writer uses them only while they still decode to the value.
//
// Noise matrices. Order: translation, rotation. For a pose the deviation from the measured value is measured⁻¹ · predicted:
// translation in the frame of the MEASURED pose, rotation vector (full angle). `written` is in the coordinates of its format:
//   PyFG  COVARIANCE of just this. Rotation: full angle [rad²] (PyFactorGraph and CORA take κ = 3 / (2 tr Σ_rot) for 2κ‖φ‖²). They
//         only use traces, so the frame of the translation is nowhere stated; we take g2o's.
//   g2o   INFORMATION of just this in EDGE_SE2; in EDGE_SE3:QUAT the rotation is the vector part of the quaternion: half the angle.
//   TORO  INFORMATION with the translation in the frame of the FIRST pose (as its own optimiser has it). Roll, pitch, yaw are
//         those of the deviation, near zero, where they equal the rotation vector.
// The edges' information() is what the factors ask for. RelativePoseEdge (Between): of measured⁻¹ · predicted, so for g2o in space the
// rotation block is divided by 4, the cross blocks by 2, the translation block is as written. PriorEdge (Prior): of holdfast's
// tangent measured.local(x), so moreover the translation is turned into the world.
#pragma once

#include <Eigen/Cholesky>
#include <array>
#include <cstddef>
#include <cstdint>
#include <holdfast/graph/error.hpp>
#include <holdfast/graph/key.hpp>
#include <holdfast/graph/variables.hpp>
#include <memory>
#include <optional>
#include <string>
#include <unordered_set>
#include <variant>
#include <vector>

namespace holdfast {

enum class Format { PyFG, G2o, Toro };

/// What a file itself does not say.
struct ReadOptions {
  bool full_angle = false;  ///< g2o: informations of EDGE_SE3:QUAT are of the full angle, as GTSAM writes them, not of half the angle
  bool toro_rows = false;   ///< TORO: the informations of EDGE2 stand row by row (iSAM, HOG-Man, SLAM++), not in TORO's order
  /// What the numbers after iSAM's ODOMETRY and LANDMARK are: the square root R of the information RᵀR, as iSAM itself has it; others wrote
  /// an information or (GTSAM's victoria_park.txt) a covariance into such files.
  enum class IsamNoise { root, information, covariance };
  IsamNoise isam_noise = IsamNoise::root;
  bool repair = false;  ///< an indefinite matrix is replaced by the nearest semidefinite one (Dataset::repairs), not refused
};

inline const char* to_string(Format format) {
  static constexpr std::array<const char*, 3> names{"PyFG", "g2o", "TORO"};
  return names[static_cast<std::size_t>(format)];
}

/// The numbers of a value in the file: x y θ | x y z qx qy qz qw | x y z roll pitch yaw | x y | x y z. Empty: none known.
struct Columns {
  std::array<double, 7> number{};
  int size = 0;
};

/// d(coordinates of `format`) / d(measured⁻¹ · predicted); see the head of this file. full_angle: as ReadOptions has it.
template <class V>
Matrix<V::dim, V::dim> noise_coordinates(Format format, const V& measured, bool full_angle = false) {
  constexpr int space = V::space_dim;
  Matrix<V::dim, V::dim> J = Matrix<V::dim, V::dim>::Identity();
  if constexpr (V::dim > space) {
    if (format == Format::Toro) J.template topLeftCorner<space, space>() = measured.rotation();
    if (format == Format::G2o && space == 3 && !full_angle) J.template bottomRightCorner<V::dim - space, V::dim - space>() *= 0.5;
  }
  return J;
}

namespace detail {
template <int N>
Matrix<N, N> inverse_of_symmetric(const Matrix<N, N>& S) {
  const auto cholesky = S.llt();
  const Matrix<N, N> inverse = cholesky.solve(Matrix<N, N>::Identity());
  if (cholesky.info() != Eigen::Success || !inverse.allFinite())
    fail<BadNumber>("the noise matrix with diagonal [", S.diagonal().transpose(),
                    "] has no inverse; where an information is 0 there is no covariance: write a format that holds information (g2o)");
  return 0.5 * (inverse + inverse.transpose());
}
template <int N>
Matrix<N, N> congruence(const Matrix<N, N>& J, const Matrix<N, N>& S) {
  const Matrix<N, N> product = J.transpose() * S * J;
  return 0.5 * (product + product.transpose());
}
}  // namespace detail

/// A symmetric matrix in the convention of `format`: a covariance is positive definite, an information may be positive semidefinite.
template <int N>
struct MatrixNoise {
  Matrix<N, N> written = Matrix<N, N>::Identity();
  Format format = Format::PyFG;
  bool full_angle = false;  ///< g2o in space, see ReadOptions

  bool is_covariance() const { return format == Format::PyFG; }

  /// Information of measured⁻¹ · predicted: translation in the frame of the measured pose, full-angle rotation vector.
  template <class V>
  Matrix<N, N> information(const V& measured) const {
    static_assert(V::dim == N);
    return detail::congruence<N>(noise_coordinates(format, measured, full_angle),
                                 is_covariance() ? detail::inverse_of_symmetric<N>(written) : written);
  }
  /// Information of holdfast's tangent measured.local(predicted): the translation in the frame the measured value is expressed in.
  template <class V>
  Matrix<N, N> tangent_information(const V& measured) const {
    Matrix<N, N> J = Matrix<N, N>::Identity();
    if constexpr (N > V::space_dim) J.template topLeftCorner<V::space_dim, V::space_dim>() = measured.rotation().transpose();
    return detail::congruence<N>(J, information(measured));
  }
  /// The same noise in the convention of another format; exactly `*this` where it is the same format.
  template <class V>
  MatrixNoise converted(Format to, const V& measured) const {
    return to == format ? *this : of_information(information(measured), to, measured);
  }
  /// What a file of this format says of an information of measured⁻¹ · predicted. Throws BadNumber where it has no covariance and needs
  /// one.
  template <class V>
  static MatrixNoise of_information(const Matrix<N, N>& information, Format format, const V& measured) {
    const Matrix<N, N> deviation_of_coordinates = noise_coordinates(format, measured).inverse();
    const Matrix<N, N> I = detail::congruence<N>(deviation_of_coordinates, information);
    return {format == Format::PyFG ? detail::inverse_of_symmetric<N>(I) : I, format};
  }
};

using VertexValue = std::variant<Pose2, Pose3, Point2, Point3>;

struct Vertex {
  Key key;
  VertexValue value;
  Columns columns;
  std::optional<double> time;  ///< [s]
  std::size_t line = 0;        ///< in the file; 0: made, not read
};

/// T_first_second, V = Pose2 or Pose3; or the step from one point to another, in the world: V = Point2 or Point3.
template <class V>
struct RelativePoseEdge {
  Key first, second;
  V measured;
  Columns columns;
  MatrixNoise<V::dim> noise;
  Matrix<V::dim, V::dim> information() const { return noise.information(measured); }
};

/// p_pose: the landmark in the frame of the pose. P = Point2 or Point3.
template <class P>
struct RelativePointEdge {
  Key pose, landmark;
  P measured;
  Columns columns;
  MatrixNoise<P::dim> noise;
  std::optional<std::uint64_t> offset = {};  ///< id of a SensorOffset that is the identity, as g2o's EDGE_SE3_TRACKXYZ names one
  Matrix<P::dim, P::dim> information() const { return noise.information(measured); }
};

struct RangeEdge {
  Key first, second;
  double distance = 0;     ///< [m]
  double variance = 1;     ///< [m²]
  double information = 0;  ///< [1/m²] as a g2o file has it; 0: it is 1 / variance
};

/// The direction from a pose in the plane to a landmark, in the frame of the pose, counterclockwise from its x axis.
struct BearingEdge {
  Key pose, landmark;
  double angle = 0;        ///< [rad]
  double information = 1;  ///< [1/rad²]
};

/// A direct measurement of one variable. V = Pose2, Pose3, Point2 or Point3.
template <class V>
struct PriorEdge {
  Key key;
  V measured;
  Columns columns;
  MatrixNoise<V::dim> noise;
  std::optional<std::uint64_t> offset = {};  ///< id of a SensorOffset that is the identity, as g2o's EDGE_SE3_PRIOR names one
  Matrix<V::dim, V::dim> information() const { return noise.tangent_information(measured); }
};

/// A measured position of a pose (GPS): says nothing of its rotation. Noise in the axes of the world. P = Point2 or Point3.
template <class P>
struct PositionEdge {
  Key key;
  P measured;
  Columns columns;
  MatrixNoise<P::dim> noise;
  Matrix<P::dim, P::dim> information() const { return noise.information(measured); }
};

using Measurement = std::variant<RelativePoseEdge<Pose2>, RelativePoseEdge<Pose3>, RelativePointEdge<Point2>, RelativePointEdge<Point3>,
                                 RangeEdge, PriorEdge<Pose2>, PriorEdge<Pose3>, PriorEdge<Point2>, PriorEdge<Point3>, BearingEdge,
                                 PositionEdge<Point2>, PositionEdge<Point3>, RelativePoseEdge<Point2>, RelativePoseEdge<Point3>>;

struct Original;

struct Edge {
  Measurement measurement;
  std::optional<double> time;  ///< [s]
  std::size_t line = 0;
  const char* tag = "";  ///< of its line (a literal), "" where it was made
  /// Its line, where the measurement does not hold all that it says (a switch, a sensor offset, no information): a writer of the same
  /// format takes it while the measurement is as it was read.
  std::shared_ptr<const Original> original = {};
};

struct Original {
  std::string text;
  std::vector<Measurement> measurements;  ///< of the edges of this line, which share it
};

/// One key of a FIX line; a key may be fixed more than once.
struct Fixed {
  Key key;
  std::size_t line = 0;
};

/// g2o's PARAMS_SE3OFFSET and PARAMS_SE2OFFSET: the sensor in the body. Measurements that name one are turned into the body's frame when
/// they are read: landmarks exactly; of poses the information is exact to first order in the deviation.
struct SensorOffset {
  std::uint64_t id = 0;
  Pose3 T_body_sensor;  ///< in the plane: z = 0 and about z
  Columns columns;
  std::size_t line = 0;
  bool in_plane = false;
};

/// An indefinite matrix and what it was replaced by (ReadOptions::repair).
struct Repair {
  std::size_t line = 0;
  double smallest = 0;  ///< its smallest eigenvalue, < 0
  double moved = 0;     ///< by how much: Frobenius norm of the difference, relative to that of the matrix
};

/// A comment or a blank line.
struct KeptLine {
  std::string text;
  std::size_t line = 0;
};

/// A line whose tag no reader knows: kept as it is, written back into the same format.
struct UnknownLine {
  std::string tag;
  std::string text;
  std::size_t line = 0;
};

struct UnknownTag {
  std::string tag;
  std::size_t count = 0;
  std::size_t first_line = 0;
};

struct Dataset {
  Format format = Format::PyFG;
  std::string name;  ///< the file, for messages
  std::vector<Vertex> vertices;
  std::vector<Edge> edges;  ///< in the order of the file
  std::vector<Fixed> fixed;
  std::vector<SensorOffset> offsets;
  std::vector<UnknownLine> unknown;
  /// g2o and TORO: the keys x<n> whose id in the file is gtsam::Symbol('x', n), not the number n; they are written so again.
  std::unordered_set<Key> symbols;
  ReadOptions reading;             ///< how it was read; a writer of the same format writes it so again
  std::vector<KeptLine> comments;  ///< and blank lines
  std::vector<Repair> repairs;
  std::vector<std::size_t> no_noise;  ///< lines of edges without an information: taken for the identity
  bool landmarks_apart = false;       ///< g2o: ids of landmarks are numbered apart from those of poses (GTSAM): id 0 is x0 and l0
  std::size_t line_count = 0;         ///< of the file
};

/// The unknown tags in the order of their first line.
std::vector<UnknownTag> unknown_tags(const Dataset& dataset);

/// One line for the user: "graph.g2o: 3 lines of 2 unknown tags left out: FOO (2, first in line 7), BAR (1, first in line 9)"; else empty.
std::string unknown_report(const Dataset& dataset);

/// The keys of a measurement: one for a prior, two for anything else.
std::vector<Key> keys_of(const Measurement& measurement);

/// For messages: "range A1 L0 (line 12)".
std::string describe(const Edge& edge);

}  // namespace holdfast
