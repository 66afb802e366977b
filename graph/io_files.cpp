#include <holdfast/graph/io_atomic.hpp>
#include <holdfast/graph/io_files.hpp>
#include <holdfast/graph/io_formats.hpp>
#include <holdfast/graph/io_parser.hpp>
#include <istream>
#include <iterator>

namespace holdfast {
namespace {

Dataset parse_text(std::string_view text, const std::string& name, Format format) {
  LineParser parser(format, name);
  io::for_each_line(text, [&](std::size_t number, std::string_view line) {
    const bool is_cut = line.data() + line.size() == text.data() + text.size();  // the last line, without a line end
    try {
      parser.parse(number, line);
    } catch (const BadFile& problem) {
      if (!is_cut) throw;
      fail<BadFile>(problem.what(), " (the last line, without a line end: is the file cut?)");
    }
  });
  Dataset dataset = parser.finish();
  if (dataset.vertices.empty() && dataset.edges.empty())
    fail<BadFile>("cannot read ", name, ": it holds no vertex and no edge of ", holdfast::name(format));
  return dataset;
}

std::string all_of(std::istream& in, const std::string& name) {
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (in.bad()) fail<BadFile>("cannot read ", name, ": the stream failed");
  if (text.empty()) fail<BadFile>("cannot read ", name, ": it is empty (0 bytes)");
  return text;
}

}  // namespace

Dataset read(const std::string& path) {
  const std::string text = io::read_file(path);
  return parse_text(text, path, io::recognise(text, path));
}

Dataset read(const std::string& path, Format format) { return parse_text(io::read_file(path), path, format); }

Dataset parse(std::istream& in, const std::string& name) {
  const std::string text = all_of(in, name);
  return parse_text(text, name, io::recognise(text, name));
}

Dataset parse(std::istream& in, const std::string& name, Format format) { return parse_text(all_of(in, name), name, format); }

void write_pyfg(const std::string& path, const Dataset& dataset) { atomic_write(path, to_pyfg(dataset)); }
void write_g2o(const std::string& path, const Dataset& dataset) { atomic_write(path, to_g2o(dataset)); }
void write_toro(const std::string& path, const Dataset& dataset) { atomic_write(path, to_toro(dataset)); }

}  // namespace holdfast
