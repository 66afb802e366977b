// A reader of JSON for files of measurements: a tree whose nodes know the line they stand in. Numbers keep their text, so that a 64-bit
// key loses nothing. Internal to the readers.
#pragma once

#include <cstdint>
#include <holdfast/graph/error.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace holdfast::io {

struct JsonValue {
  enum class Type { null, boolean, number, text, list, object };
  Type type = Type::null;
  std::string_view raw;          ///< as it stands in the file
  std::string name;              ///< of a member of an object
  std::string text;              ///< of a text
  std::vector<JsonValue> items;  ///< of a list, or the members of an object in their order
  std::size_t line = 0;

  /// The member, or null. Where a name occurs again the first counts.
  const JsonValue* find(std::string_view member) const;
};

/// The whole text is one value; BadFile names file, line and what was expected. The text must outlive the tree.
JsonValue parse_json(std::string_view text, const std::string& file);

/// `text` in quotes.
std::string to_json_text(std::string_view text);

}  // namespace holdfast::io
