#include <holdfast/graph/files/atomic.hpp>
#include <holdfast/graph/files/files.hpp>
#include <holdfast/graph/files/internal/formats.hpp>
#include <holdfast/graph/files/internal/parser.hpp>
#include <istream>
#include <iterator>

namespace holdfast {
namespace {

// A tag cut short is unknown, too, but must not pass for one: the last line, without a line end, begins a tag of the format.
void refuse_cut_tag(const Dataset& dataset, std::size_t number) {
  if (dataset.unknown.empty() || dataset.unknown.back().line != number) return;
  const std::string& tag = dataset.unknown.back().tag;
  for (const io::RecordType& record : io::dialect_of(dataset.format))
    if (record.tag.substr(0, tag.size()) == tag)
      fail<BadFile>(dataset.name, ", line ", number, ": '", dataset.unknown.back().text, "' is no tag; expected ", record.tag,
                    " and its columns (the last line, without a line end: is the file cut?)");
}

Dataset parse_text(std::string_view text, const std::string& name, Format format) {
  LineParser parser(format, name);
  io::for_each_line(text, [&](std::size_t number, std::string_view line) {
    const bool is_cut = line.data() + line.size() == text.data() + text.size();  // the last line, without a line end
    try {
      parser.parse(number, line);
      if (is_cut) refuse_cut_tag(parser.dataset(), number);
    } catch (const BadFile& problem) {
      if (!is_cut || std::string_view(problem.what()).find("is the file cut?") != std::string_view::npos) throw;
      fail<BadFile>(problem.what(), " (the last line, without a line end: is the file cut?)");
    }
  });
  Dataset dataset = parser.finish();
  if (dataset.vertices.empty() && dataset.edges.empty())
    fail<BadFile>("cannot read ", name, ": it holds no vertex and no edge of ", to_string(format));
  return dataset;
}

std::string all_of(std::istream& in, const std::string& name) {
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (in.bad()) fail<BadFile>("cannot read ", name, ": the stream failed");
  if (text.empty()) fail<BadFile>("cannot read ", name, ": it is empty (0 bytes)");
  return text;
}

}  // namespace

Dataset read_dataset(const std::string& path) {
  const std::string text = io::read_file(path);
  return parse_text(text, path, io::recognise(text, path));
}

Dataset read_dataset(const std::string& path, Format format) { return parse_text(io::read_file(path), path, format); }

Dataset parse_dataset(std::istream& in, const std::string& name) {
  const std::string text = all_of(in, name);
  return parse_text(text, name, io::recognise(text, name));
}

Dataset parse_dataset(std::istream& in, const std::string& name, Format format) { return parse_text(all_of(in, name), name, format); }

void write_dataset(const std::string& path, const Dataset& dataset, Format format) { atomic_write(path, to_text(dataset, format)); }

}  // namespace holdfast
