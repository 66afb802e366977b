// The pieces that the records of every format are made of: values, keys and matrices as columns. Internal to the readers and writers.
#pragma once

#include <cstring>
#include <holdfast/graph/files/dataset.hpp>
#include <holdfast/graph/files/internal/text.hpp>
#include <tuple>

namespace holdfast::io {

/// How many columns a value has in a format.
template <class V>
constexpr int column_count(Format format) {
  if constexpr (std::is_same_v<V, Pose3>) return format == Format::Toro ? 6 : 7;
  return V::dim;
}
/// How many numbers a symmetric matrix has.
constexpr int triangle_count(int dim) { return dim * (dim + 1) / 2; }

/// The value of the columns. The quaternion of a Pose3 is normalised here.
template <class V>
V decode(const Columns& columns);
/// Columns of a value that has none.
template <class V>
Columns encode(const V& value, Format format);

/// What to write for a value: the columns it was read from while they are of this format and still mean the value, else new ones.
template <class V>
Columns columns_of(const V& value, const Columns& columns, Format format) {
  if (columns.size == column_count<V>(format)) {
    const V read = decode<V>(columns);
    if (std::memcmp(static_cast<const void*>(&read), static_cast<const void*>(&value), sizeof(V)) == 0) return columns;
  }
  return encode(value, format);
}

template <class V>
Columns read_columns(Line& line, Format format);
/// Upper triangle row by row (TORO in the plane: 11 12 22 33 13 23); the identity where the line ends before it. An error where a
/// covariance is not positive definite or an information not positive semidefinite, unless it is repaired.
template <int N>
MatrixNoise<N> read_noise(Line& line, Format format);
/// The same of a matrix that is read.
template <int N>
void check_noise(Line& line, MatrixNoise<N>& noise);
Key read_key(Line& line, Format format);
Key read_landmark(Line& line, Format format);
/// Two keys, an error where they are the same.
std::pair<Key, Key> read_keys(Line& line, Format format, bool to_landmark = false);

/// Does the edge have a place for the id of a sensor offset?
template <class E, class = void>
struct HasOffset : std::false_type {};
template <class E>
struct HasOffset<E, std::void_t<decltype(E::offset)>> : std::true_type {};
std::optional<std::uint64_t> offset_of(const Measurement& measurement);

/// What one line holds.
using Record = std::variant<Vertex, Edge, std::vector<Fixed>, SensorOffset, std::vector<Edge>>;

/// PyFG alone has time stamps: on all its lines but the vertices of points.
constexpr bool has_time(Format format, bool of_point_vertex = false) { return format == Format::PyFG && !of_point_vertex; }
std::optional<double> read_time(Line& line, bool is_there);

template <class V>
Vertex read_vertex(Line& line, Format format) {
  const std::optional<double> time = read_time(line, has_time(format, V::dim == V::space_dim));
  Vertex vertex{V::dim == V::space_dim ? read_landmark(line, format) : read_key(line, format), V(), read_columns<V>(line, format), time,
                line.number()};
  vertex.value = decode<V>(vertex.columns);
  return vertex;
}

// What stands before the numbers of an edge, and the numbers.
template <class V>
void read_keys(Line& line, Format format, RelativePoseEdge<V>& edge) {
  std::tie(edge.first, edge.second) = read_keys(line, format);
}
template <class P>
void read_keys(Line& line, Format format, RelativePointEdge<P>& edge) {
  std::tie(edge.pose, edge.landmark) = read_keys(line, format, true);
}
template <class P>
void read_keys(Line& line, Format format, PositionEdge<P>& edge) {
  edge.key = read_key(line, format);
}
template <class V>
void read_keys(Line& line, Format format, PriorEdge<V>& edge) {
  edge.key = V::dim == V::space_dim ? read_landmark(line, format) : read_key(line, format);
}
template <class E>
void read_numbers(Line& line, Format format, E& edge) {
  using V = decltype(edge.measured);
  edge.columns = read_columns<V>(line, format);
  edge.measured = decode<V>(edge.columns);
  edge.noise = read_noise<V::dim>(line, format);
}
void read_range(Line& line, Format format, RangeEdge& edge);
void read_bearing(Line& line, Format format, BearingEdge& edge);

/// The edge as it is in the body, where its line names sensors that are not at the body. offsets: in the order of the line.
void mount(Measurement& measurement, const std::vector<const SensorOffset*>& offsets);
/// Bit by bit.
bool is_same(const Measurement& a, const Measurement& b);

/// An edge's line: time (PyFG), keys, the id of a sensor offset (g2o, where the line has one), numbers.
template <class E>
Edge read_edge(Line& line, Format format, bool names_offset) {
  const std::optional<double> time = read_time(line, has_time(format));
  E edge;
  if constexpr (std::is_same_v<E, RangeEdge>) {
    read_range(line, format, edge);
  } else if constexpr (std::is_same_v<E, BearingEdge>) {
    read_bearing(line, format, edge);
  } else {
    read_keys(line, format, edge);
    if constexpr (HasOffset<E>::value)
      if (names_offset) {
        edge.offset = line.next_index("the id of a sensor offset");
        line.reading.offsets.push_back(*edge.offset);
      }
    read_numbers(line, format, edge);
  }
  return {edge, time, line.number()};
}

/// The columns of a value, and its noise in the convention of `format`, into the line being written.
void write_columns(Text& text, const Columns& columns);
template <int N>
void write_noise(Text& text, const MatrixNoise<N>& noise, bool toro_rows = false);
template <class V>
void write_value(Text& text, const V& value, const Columns& columns, Format format) {
  write_columns(text, columns_of(value, columns, format));
}
/// `x11` as `11`, another key as its 64 bits (Text::id); BadFile where the key has no integer id.
void write_id(Text& text, Key key, Format format, const std::string& record);
/// `A11`; BadFile where the key has no such name.
void write_name(Text& text, Key key, const std::string& record);
/// A name in PyFG, else an id.
void write_key(Text& text, Key key, Format format, const std::string& record);
/// BadFile: a record that `format` has no line for.
[[noreturn]] void cannot_hold(Format format, const std::string& record, const std::string& why);
std::string describe(const Vertex& vertex);

}  // namespace holdfast::io
