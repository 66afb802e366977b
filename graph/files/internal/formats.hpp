// The dialects as tables: a tag, its columns, and the function that reads them. Internal to the readers.
#pragma once

#include <holdfast/graph/files/internal/records.hpp>

namespace holdfast::io {

struct RecordType {
  std::string_view tag;
  std::size_t columns;  ///< tag included; 0: two and more
  const char* layout;   ///< for messages
  Record (*read)(Line& line);
};

struct RecordTable {
  const RecordType* first;
  const RecordType* last;
  const RecordType* begin() const { return first; }
  const RecordType* end() const { return last; }
};

RecordTable pyfg_records();
RecordTable g2o_records();
RecordTable toro_records();
RecordTable records(Format format);

/// The record of a tag, or null.
const RecordType* find_record(Format format, std::string_view tag);

/// The dialect of a line by its tag, and for the tags that PyFG and g2o share by the columns where a name or an id must be.
/// Nothing where the tag is unknown or the line is of neither.
std::optional<Format> dialect(const Line& line);

/// The dialect of a file: that of the first line that has one. BadFile where there is none.
Format recognise(std::string_view text, const std::string& name);

}  // namespace holdfast::io
