// One writer for all formats: what a line holds names its tag in the format's table (internal/formats.hpp).
#include <algorithm>
#include <holdfast/graph/files/files.hpp>
#include <holdfast/graph/files/internal/formats.hpp>
#include <holdfast/graph/files/jrl.hpp>
#include <limits>

namespace holdfast {
namespace {

using io::Holds;

class Writer {
 public:
  Writer(const Dataset& dataset, const io::Dialect& dialect)
      : dataset_(dataset), dialect_(dialect), format_(dialect.format), text_(dataset) {}

  std::string write() {
    if (!dataset_.fixed.empty()) row(Holds::fixed, describe(dataset_.fixed.front()));
    for (const SensorOffset& offset : dataset_.offsets) row_of(offset);
    if (needs_identity()) add_identity();
    for (const KeptLine& comment : dataset_.comments) place(Kind::comment, comment.line, [&] { write_line(comment.text); });
    for (const SensorOffset& offset : dataset_.offsets) place(Kind::offset, offset.line, [&] { write(offset); });
    for (const Vertex& vertex : dataset_.vertices) place(Kind::vertex, vertex.line, [&] { write(vertex); });
    for (std::size_t i = 0; i < dataset_.fixed.size();) i = write_fixed(i);
    for (const Edge& edge : dataset_.edges) place(Kind::edge, edge.line, [&] { write(edge); });
    for (const UnknownLine& unknown : dataset_.unknown) place(Kind::unknown, unknown.line, [&] { write(unknown); });
    return in_order();
  }

 private:
  /// In the order of a file whose lines have no numbers.
  enum class Kind { comment, offset, vertex, fixed, edge, unknown };
  struct Place {
    std::size_t line;
    Kind kind;
    std::size_t begin, end;  ///< in the text
  };

  /// Writes one record and notes where it belongs. Records of a kind stay in the order of the dataset.
  template <class Write>
  void place(Kind kind, std::size_t line, const Write& write_record) {
    const std::size_t begin = text_.size();
    write_record();
    std::size_t& last = last_[static_cast<std::size_t>(kind)];
    if (line > 0) last = std::max(last, line);
    places_.push_back({line > 0 ? last : 0, kind, begin, text_.size()});
  }
  std::string in_order() {
    const std::string all = text_.take();
    const bool keep_lines = dataset_.format == format_;
    constexpr std::size_t kEnd = std::numeric_limits<std::size_t>::max();
    std::size_t first_edge = kEnd;
    for (const Place& one : places_)
      if (one.kind == Kind::edge && one.line > 0) first_edge = std::min(first_edge, one.line);
    for (Place& one : places_) {
      if (!keep_lines) one.line = 0;
      if (!keep_lines || one.line > 0 || last_[static_cast<std::size_t>(Kind::edge)] == 0) continue;
      if (one.kind == Kind::vertex || one.kind == Kind::fixed) one.line = first_edge;
      if (one.kind == Kind::edge || one.kind == Kind::unknown) one.line = kEnd;
    }
    std::stable_sort(places_.begin(), places_.end(),
                     [](const Place& a, const Place& b) { return a.line != b.line ? a.line < b.line : a.kind < b.kind; });
    std::string text;
    text.reserve(all.size());
    for (const Place& one : places_) text.append(all, one.begin, one.end - one.begin);
    return text;
  }

  void write_line(const std::string& text) {
    text_.word(text);
    text_.end_line();
  }
  void write(const UnknownLine& unknown) {
    if (dataset_.format != format_ || is_of_jrl(unknown))
      io::cannot_hold(format_, "line " + std::to_string(unknown.line) + " '" + io::excerpt(unknown.text) + "' of " + dataset_.name,
                      "its tag is unknown; clear `unknown` to leave it out");
    write_line(unknown.text);
  }

  // g2o's EDGE_SE3_TRACKXYZ names a sensor offset, whether the edge does or not.
  bool needs_identity() const {
    if (format_ != Format::G2o) return false;
    return std::any_of(dataset_.edges.begin(), dataset_.edges.end(), [&](const Edge& edge) {
      const auto* point = std::get_if<RelativePointEdge<Point3>>(&edge.measurement);
      return point != nullptr && !point->offset && !has_text(edge);
    });
  }
  void add_identity() {
    for (const SensorOffset& offset : dataset_.offsets) {
      if (!offset.in_plane && Pose3().local(offset.T_body_sensor).isZero(0)) {
        identity_ = offset.id;
        return;
      }
      identity_ = std::max(identity_, offset.id + 1);
    }
    SensorOffset identity;
    identity.id = identity_;
    place(Kind::offset, 0, [&] { write(identity); });
  }

  /// g2o's ranges go from a pose in the plane to a landmark; a range is the same in both directions.
  std::vector<Key> pose_and_landmark(const RangeEdge& edge, const std::string& record) {
    if (landmarks_.empty() && poses_.empty())
      for (const Vertex& vertex : dataset_.vertices) {
        if (std::holds_alternative<Pose2>(vertex.value)) poses_.insert(vertex.key);
        if (std::holds_alternative<Point2>(vertex.value)) landmarks_.insert(vertex.key);
      }
    const auto fits = [&](Key pose, Key landmark) { return poses_.count(pose) == 0 ? false : landmarks_.count(landmark) != 0; };
    if (edge.information > 0 || fits(edge.first, edge.second)) return {edge.first, edge.second};
    if (fits(edge.second, edge.first)) return {edge.second, edge.first};
    io::cannot_hold(format_, record, "its ranges go from a pose in the plane to a landmark that have vertices; write PyFG");
  }

  /// May the line be written as it was read? All its edges must be there, one after the other, as they were.
  bool has_text(const Edge& edge) const {
    if (!edge.original || format_ != dataset_.format) return false;
    const std::vector<Measurement>& read = edge.original->measurements;
    const Edge* first = &edge;
    while (first > dataset_.edges.data() && (first - 1)->original == edge.original) --first;
    const Edge* end = dataset_.edges.data() + dataset_.edges.size();
    if (static_cast<std::size_t>(end - first) < read.size()) return false;
    for (std::size_t i = 0; i < read.size(); ++i)
      if (first[i].original != edge.original || !io::is_same(read[i], first[i].measurement)) return false;
    return static_cast<std::size_t>(&edge - first) < read.size();
  }

  static std::string describe(const Fixed& fixed) { return "the fixed variable " + fixed.key.str(); }

  /// The row of the format's table for this; null where it can be left out, BadFile naming the record where it cannot.
  const io::RecordType* row(Holds holds, const std::string& record, std::size_t type = 0, bool names_offset = false) const {
    for (const io::RecordType& one : dialect_)
      if (one.holds == holds && one.type == type && one.names_offset == names_offset && !one.is_alias) return &one;
    const char* why = dialect_.why_not(holds, type);
    if (why != nullptr) io::cannot_hold(format_, record, why);
    return nullptr;
  }
  const io::RecordType* row_of(const SensorOffset& offset) const {
    return row(Holds::sensor_offset, "a sensor offset", offset.in_plane ? 1 : 0);
  }
  std::optional<std::uint64_t> offset_of(const Edge& edge) const {
    if (format_ != Format::G2o) return std::nullopt;
    const std::optional<std::uint64_t> named = io::offset_of(edge.measurement);
    return !named && std::holds_alternative<RelativePointEdge<Point3>>(edge.measurement) ? identity_ : named;
  }

  void write_time(const std::optional<double>& time, bool wanted, const std::string& record) {
    if (wanted && !time) io::cannot_hold(format_, record, "it has no time stamp; give it one");
    if (!wanted && time)
      io::cannot_hold(format_, record,
                      io::has_time(format_) ? "its point vertices have no time stamp; clear it" : "it has no time stamps; clear them");
    if (time) text_.number(*time);
  }

  void write(const SensorOffset& offset) {
    const io::RecordType* line = row_of(offset);
    if (line == nullptr) return;
    text_.word(line->tag).word(std::to_string(offset.id));
    if (offset.in_plane)
      io::write_columns(text_, offset.columns);
    else
      io::write_value(text_, offset.T_body_sensor, offset.columns, format_);
    text_.end_line();
  }
  void write(const Vertex& vertex) {
    const std::string record = io::describe(vertex);
    const bool is_point = std::holds_alternative<Point2>(vertex.value) || std::holds_alternative<Point3>(vertex.value);
    text_.word(row(Holds::vertex, record, vertex.value.index())->tag);
    write_time(vertex.time, io::has_time(format_, is_point), record);
    io::write_key(text_, vertex.key, format_, record);
    std::visit([&](const auto& value) { io::write_value(text_, value, vertex.columns, format_); }, vertex.value);
    text_.end_line();
  }
  /// The keys of one line together; returns where the next line begins.
  std::size_t write_fixed(std::size_t i) {
    const std::size_t line = dataset_.fixed[i].line;
    place(Kind::fixed, line, [&] {
      text_.word(row(Holds::fixed, describe(dataset_.fixed[i]))->tag);
      do {
        io::write_key(text_, dataset_.fixed[i].key, format_, describe(dataset_.fixed[i]));
        ++i;
      } while (line > 0 && i < dataset_.fixed.size() && dataset_.fixed[i].line == line);
      text_.end_line();
    });
    return i;
  }
  void write(const Edge& edge) {
    if (has_text(edge)) {
      const bool is_first = &edge == dataset_.edges.data() || (&edge - 1)->original != edge.original;
      if (is_first) write_line(edge.original->text);
      return;
    }
    const std::string record = holdfast::describe(edge);
    const std::optional<std::uint64_t> offset = offset_of(edge);
    const auto* range = std::get_if<RangeEdge>(&edge.measurement);
    std::vector<Key> keys = keys_of(edge.measurement);
    if (format_ == Format::G2o && range != nullptr) keys = pose_and_landmark(*range, record);
    text_.word(row(Holds::edge, record, edge.measurement.index(), offset.has_value())->tag);
    write_time(edge.time, io::has_time(format_), record);
    for (Key key : keys) io::write_key(text_, key, format_, record);
    if (offset) text_.word(std::to_string(*offset));
    std::visit([&](const auto& measurement) { write_numbers(measurement); }, edge.measurement);
    text_.end_line();
  }
  template <class E>
  void write_numbers(const E& edge) {
    io::write_value(text_, edge.measured, edge.columns, format_);
    io::write_noise(text_, edge.noise.converted(format_, edge.measured), dataset_.format == format_ && dataset_.reading.toro_rows);
  }
  void write_numbers(const RangeEdge& edge) {
    text_.number(edge.distance);
    const bool as_read = edge.information > 0 && !(std::abs(1 / edge.information - edge.variance) > 0);
    if (format_ == Format::PyFG)
      text_.number(edge.variance);
    else
      text_.number(as_read ? edge.information : 1 / edge.variance);
  }
  void write_numbers(const BearingEdge& edge) { text_.number(edge.angle).number(edge.information); }

  const Dataset& dataset_;
  const io::Dialect& dialect_;
  Format format_;
  io::Text text_;
  std::vector<Place> places_;
  std::array<std::size_t, 6> last_{};
  std::uint64_t identity_ = 0;
  std::unordered_set<Key> poses_, landmarks_;  ///< in the plane
};

}  // namespace

std::string to_text(const Dataset& dataset, Format format) { return Writer(dataset, io::dialect_of(format)).write(); }

}  // namespace holdfast
