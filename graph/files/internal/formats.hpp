// A format is a table of its lines: a tag, its columns, the function that reads them, and what the line holds, by which the writer finds
// the tag again. Internal to the readers and the writer.
#pragma once

#include <holdfast/graph/files/internal/records.hpp>

namespace holdfast::io {

enum class Holds { vertex, edge, fixed, sensor_offset };

struct RecordType {
  std::string_view tag;
  std::size_t columns;  ///< tag included; 0: two and more
  const char* layout;   ///< for messages
  Record (*read)(Line& line);
  Holds holds;
  std::size_t type = 0;       ///< alternative of VertexValue or of Measurement
  bool names_offset = false;  ///< g2o: a column with the id of a SensorOffset
  /// Other counts of columns that are read: without the information, or as another program writes it.
  std::size_t other_columns = 0;
  /// Another name, or a line that says more than the record: read, never chosen by the writer, which gives its text back.
  bool is_alias = false;
};

struct Dialect {
  Format format;
  const RecordType* first;
  const RecordType* last;
  /// Why the format has no line for this; null: nothing is lost by leaving it out.
  const char* (*why_not)(Holds holds, std::size_t type);

  const RecordType* begin() const { return first; }
  const RecordType* end() const { return last; }
};

const Dialect& pyfg();
const Dialect& g2o();
const Dialect& toro();
const Dialect& dialect_of(Format format);

// ---- the rows of a table

/// Of the alternative T in a variant.
template <class T, class... All>
constexpr std::size_t index_in(const std::variant<All...>*) {
  std::size_t i = 0;
  const bool found = ((std::is_same_v<T, All> || (++i, false)) || ...);
  return found ? i : std::variant_npos;
}
template <class V>
inline constexpr std::size_t vertex_type = index_in<V>(static_cast<const VertexValue*>(nullptr));
template <class E>
inline constexpr std::size_t edge_type = index_in<E>(static_cast<const Measurement*>(nullptr));

template <Format format, class V>
constexpr RecordType vertex_line(std::string_view tag, std::size_t columns, const char* layout) {
  return {tag, columns, layout, [](Line& line) -> Record { return read_vertex<V>(line, format); }, Holds::vertex, vertex_type<V>};
}
/// E: RelativePoseEdge<Pose2>, …; names_offset: the line names a sensor offset.
template <Format format, class E, bool names_offset = false, bool is_alias = false>
constexpr RecordType edge_line(std::string_view tag, std::size_t columns, const char* layout, std::size_t other_columns = 0) {
  return {tag,         columns,      layout,       [](Line& line) -> Record { return read_edge<E>(line, format, names_offset); },
          Holds::edge, edge_type<E>, names_offset, other_columns,
          is_alias};
}
/// A line that a function of its own reads into an edge of type E; its text is kept.
template <class E>
constexpr RecordType special_line(std::string_view tag, std::size_t columns, const char* layout, Record (*read)(Line&),
                                  std::size_t other_columns = 0) {
  return {tag, columns, layout, read, Holds::edge, edge_type<E>, false, other_columns, true};
}

// ---- finding

/// The row of a tag, or null.
const RecordType* find_record(Format format, std::string_view tag);

/// The dialect of a line by its tag, and for the tags that PyFG and g2o share by the columns where a name or an id must be.
/// Nothing where the tag is unknown or the line is of neither.
std::optional<Format> dialect(const Line& line);

/// The dialect of a file: that of the first line that has one. BadFile where there is none.
Format recognise(std::string_view text, const std::string& name);

}  // namespace holdfast::io
