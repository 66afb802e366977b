// The pieces that the records of every format are made of: values, keys and matrices as columns. Internal to the readers and writers.
#pragma once

#include <cstring>
#include <holdfast/graph/files/dataset.hpp>
#include <holdfast/graph/files/internal/text.hpp>

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
/// Upper triangle row by row (TORO in the plane: 11 12 22 33 13 23); an error where it is not positive definite.
template <int N>
MatrixNoise<N> read_noise(Line& line, Format format);
Key read_key(Line& line, Format format);
/// Two keys, an error where they are the same.
std::pair<Key, Key> read_keys(Line& line, Format format);

/// What one line holds.
using Record = std::variant<Vertex, Edge, std::vector<Fixed>, SensorOffset>;

template <class V>
Vertex read_vertex(Line& line, Format format, std::optional<double> time) {
  Vertex vertex{read_key(line, format), V(), read_columns<V>(line, format), time, line.number()};
  vertex.value = decode<V>(vertex.columns);
  return vertex;
}
template <class V>
Edge read_relative_pose(Line& line, Format format, std::optional<double> time) {
  const auto [first, second] = read_keys(line, format);
  const Columns columns = read_columns<V>(line, format);
  return {RelativePoseEdge<V>{first, second, decode<V>(columns), columns, read_noise<V::dim>(line, format)}, time, line.number()};
}
template <class P>
Edge read_relative_point(Line& line, Format format, std::optional<double> time, bool has_offset = false) {
  const auto [pose, landmark] = read_keys(line, format);
  std::optional<std::uint64_t> offset;
  if (has_offset) offset = line.next_index("the id of a sensor offset");
  const Columns columns = read_columns<P>(line, format);
  return {RelativePointEdge<P>{pose, landmark, decode<P>(columns), columns, read_noise<P::dim>(line, format), offset}, time, line.number()};
}
template <class V>
Edge read_prior(Line& line, Format format, std::optional<double> time, bool has_offset = false) {
  const Key key = read_key(line, format);
  std::optional<std::uint64_t> offset;
  if (has_offset) offset = line.next_index("the id of a sensor offset");
  const Columns columns = read_columns<V>(line, format);
  return {PriorEdge<V>{key, decode<V>(columns), columns, read_noise<V::dim>(line, format), offset}, time, line.number()};
}

/// The columns of a value, and its noise in the convention of `format`, into the line being written.
void write_columns(Text& text, const Columns& columns);
template <int N>
void write_noise(Text& text, const MatrixNoise<N>& noise);
template <class V>
void write_value(Text& text, const V& value, const Columns& columns, Format format) {
  write_columns(text, columns_of(value, columns, format));
}
/// `x11` as `11`, another key as its 64 bits (Text::id); BadFile where the key has no integer id.
void write_id(Text& text, Key key, Format format, const std::string& record);
/// The unknown lines, which only their own format takes back.
void write_unknown(Text& text, const Dataset& dataset, Format format);

/// BadFile: a record that `format` has no line for.
[[noreturn]] void cannot_hold(Format format, const std::string& record, const std::string& why);
std::string describe(const Vertex& vertex);

}  // namespace holdfast::io
