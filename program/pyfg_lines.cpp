#include <algorithm>
#include <holdfast/graph/files/internal/parser.hpp>
#include <holdfast/program/pyfg_lines.hpp>
#include <limits>
#include <map>

namespace holdfast::program {

Dataset parse_line(std::uint64_t number, std::string_view text, const std::string& file) {
  LineParser parser(Format::PyFG, file);
  parser.parse(number, text);
  return parser.dataset();
}

std::vector<std::pair<std::uint64_t, std::string_view>> in_time_order(std::string_view text, const std::string& file) {
  struct Stamped {
    double time;
    std::uint64_t number;
    std::string_view text;
  };
  constexpr double kFirst = -std::numeric_limits<double>::infinity();
  std::vector<Stamped> lines;
  std::map<Key, double> times;
  io::for_each_line(text, [&](std::size_t number, std::string_view line) {
    double time = kFirst;  // vertices and whatever is malformed
    try {
      const Dataset one = parse_line(number, line, file);
      for (const Vertex& vertex : one.vertices)
        if (vertex.time) times[vertex.key] = *vertex.time;
      for (const Edge& edge : one.edges) {
        for (Key key : keys_of(edge.measurement)) {
          const auto it = times.find(key);
          if (it != times.end()) time = std::max(time, it->second);
        }
        if (time == kFirst) time = edge.time.value_or(kFirst);
      }
    } catch (const BadFile&) {
    }
    lines.push_back({time, number, line});
  });
  std::stable_sort(lines.begin(), lines.end(), [](const Stamped& a, const Stamped& b) { return a.time < b.time; });
  std::vector<std::pair<std::uint64_t, std::string_view>> sorted;
  for (const Stamped& line : lines) sorted.emplace_back(line.number, line.text);
  return sorted;
}

}  // namespace holdfast::program
