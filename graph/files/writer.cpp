// One writer for all formats: what a line holds names its tag in the format's table (internal/formats.hpp).
#include <holdfast/graph/files/files.hpp>
#include <holdfast/graph/files/internal/formats.hpp>

namespace holdfast {
namespace {

using io::Holds;

class Writer {
 public:
  Writer(const Dataset& dataset, const io::Dialect& dialect)
      : dataset_(dataset), dialect_(dialect), format_(dialect.format), text_(dataset.symbols) {}

  std::string write() {
    if (!dataset_.fixed.empty()) row(Holds::fixed, describe(dataset_.fixed.front()));
    if (!dataset_.offsets.empty()) row(Holds::sensor_offset, "a sensor offset");
    for (const SensorOffset& offset : dataset_.offsets) write(offset);
    for (const Vertex& vertex : dataset_.vertices) write(vertex);
    for (const Fixed& fixed : dataset_.fixed) write(fixed);
    for (const Edge& edge : dataset_.edges) write(edge);
    io::write_unknown(text_, dataset_, format_);
    return text_.take();
  }

 private:
  static std::string describe(const Fixed& fixed) { return "the fixed variable " + fixed.key.str(); }

  /// The row of the format's table for this; null where it can be left out, BadFile naming the record where it cannot.
  const io::RecordType* row(Holds holds, const std::string& record, std::size_t type = 0, bool names_offset = false) const {
    for (const io::RecordType& one : dialect_)
      if (one.holds == holds && one.type == type && one.names_offset == names_offset) return &one;
    const char* why = dialect_.why_not(holds, type);
    if (why != nullptr) io::cannot_hold(format_, record, why);
    return nullptr;
  }
  bool has_offsets() const { return format_ == Format::G2o; }

  void write_time(const std::optional<double>& time, bool wanted, const std::string& record) {
    if (wanted && !time) io::cannot_hold(format_, record, "it has no time stamp; give it one");
    if (!wanted && time)
      io::cannot_hold(format_, record,
                      io::has_time(format_) ? "its point vertices have no time stamp; clear it" : "it has no time stamps; clear them");
    if (time) text_.number(*time);
  }

  void write(const SensorOffset& offset) {
    const io::RecordType* line = row(Holds::sensor_offset, "a sensor offset");
    if (line == nullptr) return;
    text_.word(line->tag).word(std::to_string(offset.id));
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
  void write(const Fixed& fixed) {
    text_.word(row(Holds::fixed, describe(fixed))->tag);
    io::write_key(text_, fixed.key, format_, describe(fixed));
    text_.end_line();
  }
  void write(const Edge& edge) {
    const std::string record = holdfast::describe(edge);
    const std::optional<std::uint64_t> offset = has_offsets() ? io::offset_of(edge.measurement) : std::nullopt;
    text_.word(row(Holds::edge, record, edge.measurement.index(), offset.has_value())->tag);
    write_time(edge.time, io::has_time(format_), record);
    for (Key key : keys_of(edge.measurement)) io::write_key(text_, key, format_, record);
    if (offset) text_.word(std::to_string(*offset));
    std::visit([&](const auto& measurement) { write_numbers(measurement); }, edge.measurement);
    text_.end_line();
  }
  template <class E>
  void write_numbers(const E& edge) {
    io::write_value(text_, edge.measured, edge.columns, format_);
    io::write_noise(text_, edge.noise.converted(format_, edge.measured));
  }
  void write_numbers(const RangeEdge& edge) { text_.number(edge.distance).number(edge.variance); }

  const Dataset& dataset_;
  const io::Dialect& dialect_;
  Format format_;
  io::Text text_;
};

}  // namespace

std::string to_text(const Dataset& dataset, Format format) { return Writer(dataset, io::dialect_of(format)).write(); }

}  // namespace holdfast
