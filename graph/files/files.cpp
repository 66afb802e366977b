#include <algorithm>
#include <charconv>
#include <holdfast/graph/files/atomic.hpp>
#include <holdfast/graph/files/files.hpp>
#include <holdfast/graph/files/internal/formats.hpp>
#include <holdfast/graph/files/internal/parser.hpp>
#include <holdfast/graph/files/jrl.hpp>
#include <istream>
#include <iterator>
#include <unordered_set>

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

// A line cut short before its noise looks like one that has none.
void refuse_cut_noise(const Dataset& dataset, std::size_t number) {
  if (dataset.no_noise.size() == 1 && dataset.no_noise.front() == number && dataset.edges.size() > 1)
    fail<BadFile>(dataset.name, ", line ", number, ": has no noise matrix, but the edges above have; expected its numbers",
                  " (the last line, without a line end: is the file cut?)");
}

// Has some id a vertex of a pose and a vertex of a landmark?
bool landmarks_are_apart(std::string_view text, const std::string& name) {
  std::unordered_set<std::uint64_t> poses, landmarks;
  io::Line line(name);
  io::for_each_line(text, [&](std::size_t number, std::string_view content) {
    const std::size_t first = content.find_first_not_of(" \t");
    if (first == std::string_view::npos || content.substr(first, 7) != "VERTEX_") return;
    line.assign(number, content);
    const io::RecordType* type = io::find_record(Format::G2o, line.tag());
    std::uint64_t id = 0;
    const std::string_view column = line.column(1);
    if (type == nullptr || std::from_chars(column.data(), column.data() + column.size(), id).ec != std::errc{}) return;
    const bool is_pose = type->type == io::vertex_type<Pose2> || type->type == io::vertex_type<Pose3>;
    (is_pose ? poses : landmarks).insert(id);
  });
  return std::any_of(landmarks.begin(), landmarks.end(), [&](std::uint64_t id) { return poses.count(id) != 0; });
}

Dataset parse_text(std::string_view text, const std::string& name, Format format, const ReadOptions& options) {
  LineParser parser(format, name, options);
  if (format == Format::G2o && landmarks_are_apart(text, name)) parser.set_landmarks_apart();
  io::for_each_line(text, [&](std::size_t number, std::string_view line) {
    const bool is_cut = line.data() + line.size() == text.data() + text.size();  // the last line, without a line end
    try {
      parser.parse(number, line);
      if (!is_cut) return;
      refuse_cut_tag(parser.dataset(), number);
      refuse_cut_noise(parser.dataset(), number);
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

bool is_json(std::string_view text) {
  const std::size_t first = text.find_first_not_of("\xEF\xBB\xBF \t\r\n");
  return first != std::string_view::npos && text[first] == '{';
}

std::string all_of(std::istream& in, const std::string& name) {
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (in.bad()) fail<BadFile>("cannot read ", name, ": the stream failed");
  if (text.empty()) fail<BadFile>("cannot read ", name, ": it is empty (0 bytes)");
  return text;
}

}  // namespace

Dataset read_dataset(const std::string& path, const ReadOptions& options) {
  const std::string text = io::read_file(path);
  if (is_json(text)) return parse_jrl(text, path);
  return parse_text(text, path, io::recognise(text, path), options);
}

Dataset read_dataset(const std::string& path, Format format, const ReadOptions& options) {
  return parse_text(io::read_file(path), path, format, options);
}

Dataset parse_dataset(std::istream& in, const std::string& name, const ReadOptions& options) {
  const std::string text = all_of(in, name);
  if (is_json(text)) return parse_jrl(text, name);
  return parse_text(text, name, io::recognise(text, name), options);
}

Dataset parse_dataset(std::istream& in, const std::string& name, Format format, const ReadOptions& options) {
  return parse_text(all_of(in, name), name, format, options);
}

void write_dataset(const std::string& path, const Dataset& dataset, Format format) { atomic_write(path, to_text(dataset, format)); }

}  // namespace holdfast
