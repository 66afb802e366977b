#include <algorithm>
#include <holdfast/graph/files/internal/formats.hpp>
#include <holdfast/graph/files/internal/parser.hpp>

namespace holdfast {
namespace {

using io::RecordType;

struct KeyUse {
  Key key;
  std::optional<std::size_t> type;  ///< none: anything with a position
};

template <class V>
std::vector<KeyUse> uses_of(const RelativePoseEdge<V>& edge) {
  const std::size_t pose = VertexValue(edge.measured).index();
  return {{edge.first, pose}, {edge.second, pose}};
}
template <class P>
std::vector<KeyUse> uses_of(const RelativePointEdge<P>& edge) {
  const std::size_t pose = P::dim == 2 ? VertexValue(Pose2()).index() : VertexValue(Pose3()).index();
  return {{edge.pose, pose}, {edge.landmark, VertexValue(edge.measured).index()}};
}
std::vector<KeyUse> uses_of(const RangeEdge& edge) { return {{edge.first, {}}, {edge.second, {}}}; }
template <class V>
std::vector<KeyUse> uses_of(const PriorEdge<V>& edge) {
  return {{edge.key, VertexValue(edge.measured).index()}};
}

std::vector<KeyUse> uses_of(const BearingEdge& edge) {
  return {{edge.pose, VertexValue(Pose2()).index()}, {edge.landmark, VertexValue(Point2()).index()}};
}
template <class P>
std::vector<KeyUse> uses_of(const PositionEdge<P>& edge) {
  return {{edge.key, P::dim == 2 ? VertexValue(Pose2()).index() : VertexValue(Pose3()).index()}};
}

/// Of the edges whose lines name sensor offsets.
bool is_in_plane_type(std::size_t type) {
  return type == io::edge_type<RelativePoseEdge<Pose2>> || type == io::edge_type<RelativePointEdge<Point2>>;
}

std::string_view without_line_end(std::string_view text) {
  while (!text.empty() && (text.back() == '\r' || text.back() == '\n')) text.remove_suffix(1);
  return text;
}

const char* type_name(std::size_t type) {
  static constexpr std::array<const char*, 4> names{"Pose2", "Pose3", "Point2", "Point3"};
  return names[type];
}

}  // namespace

LineParser::LineParser(Format format, std::string name, const ReadOptions& options) : line_(name) {
  dataset_.format = format;
  dataset_.name = std::move(name);
  dataset_.reading = options;
  line_.reading.options = options;
  if (format == Format::Toro) set_landmarks_apart();  // iSAM's LANDMARK
}

void LineParser::set_landmarks_apart() { dataset_.landmarks_apart = line_.reading.landmarks_apart = true; }

void LineParser::parse(std::string_view text) { parse(line_.number() + 1, text); }

void LineParser::parse(std::size_t number, std::string_view text) {
  line_.assign(number, text);
  if (line_.is_blank()) {
    dataset_.comments.push_back({std::string(without_line_end(text)), number});
    return;
  }
  check_foreign();
  const RecordType* type = io::find_record(dataset_.format, line_.tag());
  if (type == nullptr) {
    dataset_.unknown.push_back({std::string(line_.tag()), std::string(without_line_end(text)), number});
    return;
  }
  const bool fits = type->columns != 0 ? line_.size() == type->columns || (type->other_columns != 0 && line_.size() == type->other_columns)
                                       : line_.size() >= 2;
  if (!fits)
    line_.error("found ", std::to_string(line_.size()), " columns; expected ",
                type->columns != 0 ? std::to_string(type->columns) : "2 or more",
                type->other_columns != 0 ? " (or " + std::to_string(type->other_columns) + ")" : "", ": ", type->layout);
  io::Record record = type->read(line_);
  check_ids();
  std::visit(
      [&](auto&& one) {
        using R = std::decay_t<decltype(one)>;
        if constexpr (std::is_same_v<R, Edge>)
          add(std::vector<Edge>{std::forward<decltype(one)>(one)}, *type);
        else if constexpr (std::is_same_v<R, std::vector<Edge>>)
          add(std::forward<decltype(one)>(one), *type);
        else
          add(std::forward<decltype(one)>(one));
      },
      std::move(record));
  for (const io::Line::XId& x : line_.x_ids())
    if (x.is_symbol) dataset_.symbols.insert(x.key);
  if (line_.reading.repair) dataset_.repairs.push_back(*line_.reading.repair);
  if (line_.reading.no_noise) dataset_.no_noise.push_back(number);
}

Dataset LineParser::finish() {
  const auto first = std::min_element(orphans_.begin(), orphans_.end(), [](const auto& a, const auto& b) {
    return a.second.line != b.second.line ? a.second.line < b.second.line : a.first < b.first;
  });
  if (first != orphans_.end()) {
    io::Line line(line_.file());
    line.assign(first->second.line, first->second.text);
    line.error("the edge names ", first->first.str(), ", which has no vertex in this file; expected a VERTEX line for every name");
  }
  Dataset done = std::move(dataset_);
  done.line_count = line_.number();
  *this = LineParser(done.format, done.name, done.reading);
  return done;
}

void LineParser::check_ids() {
  for (const auto& [key, is_symbol] : line_.x_ids()) {
    const auto [known, is_new] = spellings_.try_emplace(key, Spelling{is_symbol, line_.number()});
    if (is_new || known->second.is_symbol == is_symbol) continue;
    const auto id = [key = key](bool symbol) { return std::to_string(symbol ? key.bits() : key.id()); };
    line_.error("names ", key.str(), " by the id ", id(is_symbol), ", but line ", std::to_string(known->second.line), " by the id ",
                id(!is_symbol), "; expected one id for each variable (", key.bits(), " is gtsam::Symbol('x', ", key.step(),
                ")): give one of them another");
  }
}

void LineParser::check_foreign() const {
  const std::optional<Format> format = io::dialect(line_);
  if (!format || *format == dataset_.format) return;
  // A line of our own tag with a damaged key is ours: only the other dialect's full number of columns makes it foreign.
  const RecordType* foreign = io::find_record(*format, line_.tag());
  const bool ours = io::find_record(dataset_.format, line_.tag()) != nullptr;
  if (ours && foreign->columns != line_.size()) return;
  line_.error("this is a line of ", to_string(*format), " (", foreign->layout, "); expected ", to_string(dataset_.format),
              ", and one dialect in a file");
}

void LineParser::check_type(Key key, std::size_t type) const {
  const auto it = uses_.find(key);
  if (it != uses_.end() && it->second.type != type)
    line_.error("uses ", key.str(), " as a ", type_name(type), ", but line ", std::to_string(it->second.line), " as a ",
                type_name(it->second.type), "; expected one type for each variable");
}

void LineParser::use(Key key, std::optional<std::size_t> type) {
  const bool is_vertex_known = [&] {
    const auto it = uses_.find(key);
    return it != uses_.end() && it->second.is_vertex;
  }();
  if (type) uses_.try_emplace(key, Use{*type, line_.number(), false});
  if (dataset_.format == Format::PyFG && !is_vertex_known) orphans_.try_emplace(key, Orphan{line_.number(), std::string(line_.text())});
}

void LineParser::add(Vertex vertex) {
  const auto it = uses_.find(vertex.key);
  if (it != uses_.end() && it->second.is_vertex)
    line_.error("defines ", vertex.key.str(), " again, after line ", std::to_string(it->second.line),
                "; expected one vertex line for each variable");
  check_type(vertex.key, vertex.value.index());
  uses_[vertex.key] = {vertex.value.index(), vertex.line, true};
  orphans_.erase(vertex.key);
  dataset_.vertices.push_back(std::move(vertex));
}

void LineParser::add(std::vector<Edge> edges, const RecordType& type) {
  std::vector<const SensorOffset*> offsets;
  bool all_identity = true;
  for (const std::uint64_t id : line_.reading.offsets) {
    offsets.push_back(&offset(id, type));
    all_identity = all_identity && Pose3().local(offsets.back()->T_body_sensor).isZero(0);
  }
  std::vector<KeyUse> uses;
  for (Edge& edge : edges) {
    if (!all_identity) io::mount(edge.measurement, offsets);
    std::vector<KeyUse> more = std::visit([](const auto& e) { return uses_of(e); }, edge.measurement);
    if (dataset_.format != Format::PyFG && std::holds_alternative<RangeEdge>(edge.measurement)) {  // from a pose to a landmark
      more[0].type = VertexValue(Pose2()).index();
      more[1].type = VertexValue(Point2()).index();
    }
    uses.insert(uses.end(), more.begin(), more.end());
  }
  for (const KeyUse& key_use : uses)
    if (key_use.type) check_type(key_use.key, *key_use.type);
  for (const KeyUse& key_use : uses) use(key_use.key, key_use.type);
  std::shared_ptr<Original> original;
  if (type.is_alias || !all_identity || line_.reading.no_noise) {
    original = std::make_shared<Original>(Original{std::string(without_line_end(line_.text())), {}});
    for (const Edge& edge : edges) original->measurements.push_back(edge.measurement);
  }
  for (Edge& edge : edges) {
    edge.tag = type.tag.data();
    edge.original = original;
    dataset_.edges.push_back(std::move(edge));
  }
}

void LineParser::add(const std::vector<Fixed>& fixed) { dataset_.fixed.insert(dataset_.fixed.end(), fixed.begin(), fixed.end()); }

void LineParser::add(SensorOffset offset) {
  for (const SensorOffset& known : dataset_.offsets)
    if (known.id == offset.id)
      line_.error("defines sensor offset ", std::to_string(offset.id), " again, after line ", std::to_string(known.line),
                  "; expected one line");
  dataset_.offsets.push_back(offset);
}

const SensorOffset& LineParser::offset(std::uint64_t id, const RecordType& type) const {
  for (const SensorOffset& offset : dataset_.offsets) {
    if (offset.id != id) continue;
    if (offset.in_plane == is_in_plane_type(type.type)) return offset;
    line_.error("sensor offset ", std::to_string(id), " (line ", std::to_string(offset.line), ") is ",
                offset.in_plane ? "in the plane, the edge in space" : "in space, the edge in the plane", "; expected one of the same");
  }
  line_.error("names sensor offset ", std::to_string(id), ", which no PARAMS_SE3OFFSET or PARAMS_SE2OFFSET line above defines");
}

}  // namespace holdfast
