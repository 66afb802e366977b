#include <algorithm>
#include <holdfast/graph/files/internal/formats.hpp>

namespace holdfast::io {

const Dialect& dialect_of(Format format) {
  switch (format) {
    case Format::PyFG:
      return pyfg();
    case Format::G2o:
      return g2o();
    case Format::Toro:
      return toro();
  }
  fail<BadOption>("format ", static_cast<int>(format), " does not exist");
}

const RecordType* find_record(Format format, std::string_view tag) {
  const Dialect& lines = dialect_of(format);
  const RecordType* found = std::find_if(lines.begin(), lines.end(), [&](const RecordType& type) { return type.tag == tag; });
  return found == lines.end() ? nullptr : found;
}

std::optional<Format> dialect(const Line& line) {
  const bool in_pyfg = find_record(Format::PyFG, line.tag()) != nullptr;
  const bool in_g2o = find_record(Format::G2o, line.tag()) != nullptr;
  if (in_pyfg && in_g2o) {
    const bool has_time = line.tag() != "VERTEX_XY";
    if (is_name(line.column(has_time ? 2 : 1))) return Format::PyFG;
    if (is_integer(line.column(1))) return Format::G2o;
    return std::nullopt;
  }
  if (in_pyfg) return Format::PyFG;
  if (in_g2o) return Format::G2o;
  if (find_record(Format::Toro, line.tag()) != nullptr) return Format::Toro;
  return std::nullopt;
}

Format recognise(std::string_view text, const std::string& name) {
  std::optional<Format> format;
  Line line(name);
  Line first(name);  // the first that is no comment, for the message
  for_each_line(text, [&](std::size_t number, std::string_view content) {
    if (format) return;
    line.assign(number, content);
    if (line.is_blank()) return;
    if (first.size() == 0) first.assign(number, content);
    format = dialect(line);
    if (!format && (find_record(Format::PyFG, line.tag()) != nullptr || find_record(Format::G2o, line.tag()) != nullptr))
      line.error("expected the columns of PyFG (time name …) or of g2o (id …) after ", line.tag());
  });
  if (!format && first.size() > 0) first.error("no line of this file has a tag of PyFG, g2o or TORO; expected such as VERTEX_SE2 or EDGE2");
  if (!format) fail<BadFile>("cannot read ", name, ": it holds no records, only blank lines and comments");
  return *format;
}

}  // namespace holdfast::io
