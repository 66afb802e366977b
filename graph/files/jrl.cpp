#include <algorithm>
#include <charconv>
#include <cmath>
#include <holdfast/graph/files/atomic.hpp>
#include <holdfast/graph/files/internal/json.hpp>
#include <holdfast/graph/files/internal/records.hpp>
#include <holdfast/graph/files/jrl.hpp>
#include <map>
#include <set>

namespace holdfast {
namespace {

using io::JsonValue;

constexpr double kNanoseconds = 1e17;  // stamps from here on

/// JRL's order of a Pose3's tangent is rotation, translation.
template <int N>
Matrix<N, N> in_our_order(const Matrix<N, N>& S) {
  if constexpr (N == 6) {
    Matrix<6, 6> turned;
    turned << S.template bottomRightCorner<3, 3>(), S.template bottomLeftCorner<3, 3>(), S.template topRightCorner<3, 3>(),
        S.template topLeftCorner<3, 3>();
    return turned;
  } else {
    return S;
  }
}

// ---- reading

class Reader {
 public:
  Reader(std::string_view text, const std::string& name) : root_(io::parse_json(text, name)) {
    dataset_.format = Format::PyFG;
    dataset_.name = name;
  }

  std::vector<Vertex> read_truth() {
    if (const JsonValue* truth = root_.find("groundtruth")) read_values(*truth);
    return std::move(dataset_.vertices);
  }
  Dataset read() {
    if (root_.type != JsonValue::Type::object || root_.find("measurements") == nullptr)
      error(root_, "expected an object with the member \"measurements\" (JRL)");
    const char* values = root_.find("initialization") != nullptr ? "initialization" : "groundtruth";
    for (const JsonValue& member : root_.items) {
      if (member.name == "name" || member.name == "robots") continue;
      if (member.name == "measurements")
        read_measurements(member);
      else if (member.name == values)
        read_values(member);
      else
        keep(member.name, member);
    }
    if (!same_places_)  // lists of outliers name measurements by their places
      for (UnknownLine& line : dataset_.unknown)
        if (line.tag.find("outlier_factors") != std::string::npos) line.text = "{" + line.text + "}";
    leave_out_shared_times();
    for (Vertex& vertex : dataset_.vertices)
      if (const auto time = times_.find(vertex.key); time != times_.end() && vertex.value.index() < 2) vertex.time = time->second;
    check_types();
    if (dataset_.vertices.empty() && dataset_.edges.empty()) error(root_, "it holds no value and no measurement; expected some");
    return std::move(dataset_);
  }

 private:
  [[noreturn]] void error(const JsonValue& at, const std::string& what) const {
    fail<BadFile>(dataset_.name, ", line ", at.line, ": '", io::excerpt(at.raw.substr(0, 200)), "': ", what);
  }
  const JsonValue& member(const JsonValue& of, const char* name) const {
    const JsonValue* found = of.find(name);
    if (found == nullptr) error(of, std::string("has no member \"") + name + "\"; expected one");
    return *found;
  }
  double number(const JsonValue& value) const {
    double result = 0;
    const auto [end, problem] = std::from_chars(value.raw.data(), value.raw.data() + value.raw.size(), result);
    if (value.type != JsonValue::Type::number || problem != std::errc{} || end != value.raw.data() + value.raw.size() ||
        !std::isfinite(result))
      error(value, "expected a finite number");
    return result;
  }
  double number(const JsonValue& of, const char* name) const { return number(member(of, name)); }
  std::uint64_t integer(const JsonValue& value) const {
    std::uint64_t result = 0;
    const auto [end, problem] = std::from_chars(value.raw.data(), value.raw.data() + value.raw.size(), result);
    if (value.type != JsonValue::Type::number || problem != std::errc{} || end != value.raw.data() + value.raw.size())
      error(value, "expected an integer from 0 to 2^64 - 1");
    return result;
  }
  Key key(const JsonValue& of, const char* name) const { return Key::from_bits(integer(member(of, name))); }
  std::vector<double> numbers(const JsonValue& of, const char* name, std::size_t count) const {
    const JsonValue& list = member(of, name);
    if (list.type != JsonValue::Type::list || list.items.size() != count)
      error(list, "expected a list of " + std::to_string(count) + " numbers");
    std::vector<double> all;
    for (const JsonValue& item : list.items) all.push_back(number(item));
    return all;
  }
  void keep(const std::string& tag, const JsonValue& value) {
    dataset_.unknown.push_back({tag, io::to_json_text(tag) + ": " + std::string(value.raw), value.line});
  }

  template <class V>
  std::pair<V, Columns> value(const JsonValue& of) const {
    Columns columns;
    if constexpr (std::is_same_v<V, Pose3>) {
      const std::vector<double> t = numbers(of, "translation", 3), q = numbers(of, "rotation", 4);
      columns = {{t[0], t[1], t[2], q[1], q[2], q[3], q[0]}, 7};
      const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
      if (!(std::abs(norm - 1) <= 1e-3)) error(of, "the quaternion w x y z has norm " + io::to_text(norm) + "; expected 1 within 0.001");
    } else {
      columns.number[0] = number(of, "x");
      columns.number[1] = number(of, "y");
      if constexpr (V::dim == 3) columns.number[2] = number(of, V::space_dim == 2 ? "theta" : "z");
      columns.size = V::dim;
    }
    return {io::decode<V>(columns), columns};
  }
  template <int N>
  MatrixNoise<N> noise(const JsonValue& of) const {
    const std::vector<double> all = numbers(of, "covariance", N * N);
    const Matrix<N, N> S = Eigen::Map<const Matrix<N, N>>(all.data());
    if (!S.isApprox(S.transpose(), 1e-6)) error(of, "the covariance is not symmetric; expected a symmetric matrix");
    const Matrix<N, N> symmetric = in_our_order<N>(0.5 * (S + S.transpose()));
    if (symmetric.llt().info() != Eigen::Success) error(of, "the covariance matrix is not positive definite; expected all eigenvalues > 0");
    return {symmetric, Format::PyFG};
  }

  void read_values(const JsonValue& robots) {
    if (robots.type != JsonValue::Type::object) error(robots, "expected an object with a list of values for each robot");
    for (const JsonValue& robot : robots.items) {
      if (robot.type != JsonValue::Type::list) error(robot, "expected a list of values");
      for (const JsonValue& one : robot.items) read_value(one);
    }
  }
  void read_value(const JsonValue& one) {
    const std::string& type = member(one, "type").text;
    if (type == "Pose2")
      add_vertex<Pose2>(one);
    else if (type == "Pose3")
      add_vertex<Pose3>(one);
    else if (type == "Point2")
      add_vertex<Point2>(one);
    else if (type == "Point3")
      add_vertex<Point3>(one);
    else
      keep("value " + type, one);
  }
  template <class V>
  void add_vertex(const JsonValue& one) {
    const Key name = key(one, "key");
    const auto [where, is_new] = vertices_.emplace(name, one.line);
    if (!is_new) {  // robots may each have a value of a variable that they share
      keep("second value of " + name.str(), one);
      return;
    }
    const auto [read, columns] = value<V>(one);
    dataset_.vertices.push_back({name, read, columns, {}, one.line});
  }

  void read_measurements(const JsonValue& robots) {
    if (robots.type != JsonValue::Type::object) error(robots, "expected an object with a list of entries for each robot");
    for (const JsonValue& robot : robots.items) {
      if (robot.type != JsonValue::Type::list) error(robot, "expected a list of entries");
      std::optional<std::uint64_t> last;
      for (const JsonValue& entry : robot.items) {
        const std::uint64_t stamp = integer(member(entry, "stamp"));
        same_places_ = same_places_ && last != stamp;
        last = stamp;
        const double time = static_cast<double>(stamp) * (static_cast<double>(stamp) >= kNanoseconds ? 1e-9 : 1);
        const JsonValue* list = entry.find("measurements");
        same_places_ = same_places_ && list != nullptr && !list->items.empty();
        if (list == nullptr) continue;
        if (list->type != JsonValue::Type::list) error(*list, "expected a list of measurements");
        for (const JsonValue& one : list->items) {
          const std::size_t before = dataset_.edges.size();
          read_measurement(one, time);
          same_places_ = same_places_ && dataset_.edges.size() > before && robot.name.size() == 1 &&
                         keys_of(dataset_.edges.back().measurement).front().kind() == robot.name[0];
        }
      }
    }
  }
  void read_measurement(const JsonValue& one, double time) {
    const std::string& type = member(one, "type").text;
    if (type == "PriorFactorPose2") return add(prior<Pose2>(one), "PriorFactorPose2", one, time);
    if (type == "PriorFactorPose3") return add(prior<Pose3>(one), "PriorFactorPose3", one, time);
    if (type == "PriorFactorPoint2") return add(prior<Point2>(one), "PriorFactorPoint2", one, time);
    if (type == "PriorFactorPoint3") return add(prior<Point3>(one), "PriorFactorPoint3", one, time);
    if (type == "BetweenFactorPose2") return add(between<Pose2>(one), "BetweenFactorPose2", one, time);
    if (type == "BetweenFactorPose3") return add(between<Pose3>(one), "BetweenFactorPose3", one, time);
    if (type == "BetweenFactorPoint2") return add(between<Point2>(one), "BetweenFactorPoint2", one, time);
    if (type == "BetweenFactorPoint3") return add(between<Point3>(one), "BetweenFactorPoint3", one, time);
    for (const char* range : {"RangeFactorPose2", "RangeFactorPose3", "RangeFactor2D", "RangeFactor3D"})
      if (type == range) return add(range_of(one), range, one, time);
    if (type == "BearingRangeFactor2D" && read_bearing_range(one, time)) return;
    dataset_.unknown.push_back({type, std::string(one.raw), one.line});
  }
  template <class V>
  Measurement prior(const JsonValue& one) const {
    const auto [measured, columns] = value<V>(member(one, "prior"));
    return PriorEdge<V>{key(one, "key"), measured, columns, noise<V::dim>(one)};
  }
  template <class V>
  Measurement between(const JsonValue& one) const {
    const auto [measured, columns] = value<V>(member(one, "measurement"));
    return RelativePoseEdge<V>{key(one, "key1"), key(one, "key2"), measured, columns, noise<V::dim>(one)};
  }
  Measurement range_of(const JsonValue& one) const {
    const JsonValue& measurement = member(one, "measurement");
    const double distance = measurement.type == JsonValue::Type::object ? number(measurement, "data") : number(measurement);
    const double variance = numbers(one, "covariance", 1)[0];
    if (distance < 0 || !(variance > 0)) error(one, "expected a range >= 0 and a covariance > 0");
    return RangeEdge{key(one, "key1"), key(one, "key2"), distance, variance};
  }
  bool read_bearing_range(const JsonValue& one, double time) {
    const std::vector<double> S = numbers(one, "covariance", 4);
    const JsonValue& measurement = member(one, "measurement");
    const JsonValue& bearing = member(measurement, "bearing");
    if (std::abs(S[1]) + std::abs(S[2]) > 0 || !(S[0] > 0) || !(S[3] > 0)) return false;
    const double angle = bearing.type == JsonValue::Type::object ? number(bearing, "theta") : number(bearing);
    const double distance = number(measurement, "range");
    if (distance < 0) error(one, "expected a range >= 0");
    const Key pose = key(one, "key1"), landmark = key(one, "key2");
    add(BearingEdge{pose, landmark, angle, 1 / S[0]}, "BearingRangeFactor2D", one, time);
    add(RangeEdge{pose, landmark, distance, S[3]}, "BearingRangeFactor2D", one, time);
    return true;
  }
  /// A stamp of several states of one agent (all measurements in one entry) is the time of none.
  void leave_out_shared_times() {
    std::map<std::pair<Agent, double>, int> states;
    for (const auto& [key, time] : times_) ++states[{key.agent(), time}];
    for (auto it = times_.begin(); it != times_.end();) it = states[{it->first.agent(), it->second}] > 1 ? times_.erase(it) : std::next(it);
  }
  void add(Measurement measurement, const char* tag, const JsonValue& one, double time) {
    const std::vector<Key> keys = keys_of(measurement);
    if (keys.size() == 2 && keys[0] == keys[1]) error(one, "goes from " + keys[0].str() + " to itself; expected two different variables");
    // The stamp is that of the state that measures: of odometry the newer one, whichever way it is written; else the first.
    const bool one_agent = keys.size() == 2 && keys.front().agent() == keys.back().agent();
    times_.try_emplace(one_agent ? std::max(keys.front(), keys.back()) : keys.front(), time);
    dataset_.edges.push_back({std::move(measurement), time, one.line, tag});
  }

  /// One type for each variable.
  void check_types() const {
    std::map<Key, std::pair<std::size_t, std::size_t>> types;  // and the line
    const auto expect = [&](Key name, std::size_t type, std::size_t line) {
      const auto [it, is_new] = types.emplace(name, std::pair(type, line));
      if (!is_new && it->second.first != type)
        fail<BadFile>(dataset_.name, ", line ", line, ": uses ", name, " as another type than line ", it->second.second,
                      "; expected one type for each variable");
    };
    for (const Vertex& vertex : dataset_.vertices) expect(vertex.key, vertex.value.index(), vertex.line);
    for (const Edge& edge : dataset_.edges)
      std::visit(
          [&](const auto& one) {
            using E = std::decay_t<decltype(one)>;
            if constexpr (std::is_same_v<E, BearingEdge>) {
              expect(one.pose, VertexValue(Pose2()).index(), edge.line);
              expect(one.landmark, VertexValue(Point2()).index(), edge.line);
            } else if constexpr (!std::is_same_v<E, RangeEdge>) {
              if constexpr (std::is_constructible_v<VertexValue, decltype(one.measured)>)
                for (Key name : keys_of(Measurement(one))) expect(name, VertexValue(one.measured).index(), edge.line);
            }
          },
          edge.measurement);
  }

  JsonValue root_;
  Dataset dataset_;
  std::map<Key, std::size_t> vertices_;
  std::map<Key, double> times_;
  bool same_places_ = true;  ///< the writer puts every measurement where it stood
};

// ---- writing

class Writer {
 public:
  explicit Writer(const Dataset& dataset) : dataset_(dataset) {}

  std::string write() {
    if (!dataset_.fixed.empty()) cannot_hold("the fixed variable " + dataset_.fixed.front().key.str(), "it has none; add a prior");
    for (const UnknownLine& line : dataset_.unknown)
      if (line.text.empty() || line.text[0] != '"')
        cannot_hold("line " + std::to_string(line.line) + " '" + io::excerpt(line.text) + "'", "its tag is unknown; clear `unknown`");
    for (const Vertex& vertex : dataset_.vertices) types_[vertex.key] = vertex.value.index();
    for (const Edge& edge : dataset_.edges) {
      const std::vector<Key> keys = keys_of(edge.measurement);
      for (Key key : keys) owners_.emplace(key, keys.front().kind());
    }
    std::string text = "{\n\"name\": " + io::to_json_text(dataset_.name) + ",\n\"robots\": [";
    const std::vector<char> robots = robots_of();
    for (std::size_t i = 0; i < robots.size(); ++i) text += (i > 0 ? ", " : "") + std::to_string(static_cast<int>(robots[i]));
    text += "],\n\"measurements\": {" + measurements(robots) + "\n},\n\"initialization\": {" + values(robots) + "\n}";
    for (const UnknownLine& line : dataset_.unknown)
      if (line.text[0] == '"') text += ",\n" + line.text;
    return text + "\n}\n";
  }

 private:
  [[noreturn]] static void cannot_hold(const std::string& record, const std::string& why) {
    fail<BadFile>("a JRL file cannot hold ", record, ": ", why);
  }
  static char robot_of(Key key) { return key.kind(); }
  /// A landmark belongs to the robot that saw it first.
  char robot_of(const Vertex& vertex) const {
    const auto owner = owners_.find(vertex.key);
    return vertex.value.index() < 2 || owner == owners_.end() ? vertex.key.kind() : owner->second;
  }
  static std::string name_of(char robot) { return io::to_json_text(std::string(1, robot)); }
  std::vector<char> robots_of() const {
    std::set<char> robots;
    for (const Edge& edge : dataset_.edges) robots.insert(robot_of(keys_of(edge.measurement).front()));
    for (const Vertex& vertex : dataset_.vertices) robots.insert(robot_of(vertex));
    for (const char robot : robots)
      if (static_cast<unsigned char>(robot) < 0x20 || static_cast<unsigned char>(robot) > 0x7e)
        cannot_hold("the variables of kind " + std::to_string(static_cast<unsigned char>(robot)), "its robots are letters; rename them");
    return {robots.begin(), robots.end()};
  }
  static std::string number(double value) {
    if (!std::isfinite(value)) cannot_hold("the number " + io::to_text(value), "it is not finite");
    const std::string text = io::to_text(value);
    return text;
  }
  static std::string list(const double* numbers, int count) {
    std::string text = "[";
    for (int i = 0; i < count; ++i) text += (i > 0 ? ", " : "") + number(numbers[i]);
    return text + "]";
  }
  template <int N>
  static std::string covariance(const Matrix<N, N>& S) {
    const Matrix<N, N> ordered = in_our_order<N>(S);
    return ", \"covariance\": " + list(ordered.data(), N * N);
  }

  template <class V>
  static std::string value(const V& x, const Columns& columns) {
    const Columns c = io::columns_of(x, columns, Format::PyFG);
    const std::array<double, 7>& n = c.number;
    const std::string type = std::string("\"type\": \"") + V::name() + "\", ";
    if constexpr (std::is_same_v<V, Pose3>) {
      const double t[] = {n[0], n[1], n[2]}, q[] = {n[6], n[3], n[4], n[5]};
      return type + "\"translation\": " + list(t, 3) + ", \"rotation\": " + list(q, 4);
    } else {
      std::string text = type + "\"x\": " + number(n[0]) + ", \"y\": " + number(n[1]);
      if (V::dim == 3) text += std::string(", \"") + (V::space_dim == 2 ? "theta" : "z") + "\": " + number(n[2]);
      return text;
    }
  }
  std::string values(const std::vector<char>& robots) const {
    std::string text;
    for (const char robot : robots) {
      text += (text.empty() ? "\n" : ",\n") + name_of(robot) + ": [";
      const char* mark = "\n";
      for (const Vertex& vertex : dataset_.vertices) {
        if (robot_of(vertex) != robot) continue;
        text += std::string(mark) + "{\"key\": " + std::to_string(vertex.key.bits()) + ", " +
                std::visit([&](const auto& x) { return value(x, vertex.columns); }, vertex.value) + "}";
        mark = ",\n";
      }
      text += "]";
    }
    return text;
  }

  std::string measurements(const std::vector<char>& robots) const {
    std::string text;
    for (const char robot : robots) {
      text += (text.empty() ? "\n" : ",\n") + name_of(robot) + ": [";
      std::optional<std::uint64_t> stamp;
      bool any = false;
      for (std::size_t i = 0; i < dataset_.edges.size(); ++i) {
        const Edge& edge = dataset_.edges[i];
        if (robot_of(keys_of(edge.measurement).front()) != robot) continue;
        const std::uint64_t now = stamp_of(edge);
        if (!stamp || *stamp != now) {
          text += std::string(stamp ? "]},\n" : "\n") + "{\"stamp\": " + std::to_string(now) + ", \"measurements\": [";
          any = false;
        }
        stamp = now;
        text += any ? ",\n{" : "\n{";
        text += measurement(i) + "}";
        if (is_bearing_range(i)) ++i;
        any = true;
      }
      text += stamp ? "]}]" : "]";
    }
    return text;
  }
  static std::uint64_t stamp_of(const Edge& edge) {
    const double time = edge.time.value_or(static_cast<double>(keys_of(edge.measurement).back().step()));
    const double scaled = time != std::floor(time) ? time * 1e9 : time;  // what is no integer is in seconds, and nanoseconds hold it
    if (!(scaled >= 0) || scaled >= 1.8e19) cannot_hold(describe(edge), "its stamps are integers from 0 to 2^64 - 1; shift the times");
    return static_cast<std::uint64_t>(std::llround(scaled));
  }
  static std::string keys(Key first, Key second) {
    return "\"key1\": " + std::to_string(first.bits()) + ", \"key2\": " + std::to_string(second.bits());
  }
  /// A bearing followed by the range of the same two.
  bool is_bearing_range(std::size_t i) const {
    const auto* bearing = std::get_if<BearingEdge>(&dataset_.edges[i].measurement);
    if (bearing == nullptr || i + 1 == dataset_.edges.size()) return false;
    const auto* range = std::get_if<RangeEdge>(&dataset_.edges[i + 1].measurement);
    return range != nullptr && range->first == bearing->pose && range->second == bearing->landmark &&
           dataset_.edges[i + 1].time == dataset_.edges[i].time;
  }
  std::string measurement(std::size_t i) const {
    const Edge& edge = dataset_.edges[i];
    const auto type = [](const std::string& name) { return "\"type\": \"" + name + "\", "; };
    return std::visit(
        [&](const auto& one) -> std::string {
          using E = std::decay_t<decltype(one)>;
          if constexpr (std::is_same_v<E, RangeEdge>) {
            return type(std::string("RangeFactor") + ends_of(one, edge)) + keys(one.first, one.second) +
                   ", \"measurement\": " + number(one.distance) + ", \"covariance\": [" + number(one.variance) + "]";
          } else if constexpr (std::is_same_v<E, BearingEdge>) {
            if (!is_bearing_range(i)) cannot_hold(describe(edge), "it has bearings with a range alone");
            const auto& range = std::get<RangeEdge>(dataset_.edges[i + 1].measurement);
            const std::string bearing = "{\"type\": \"Rot2\", \"theta\": " + number(one.angle);
            return type("BearingRangeFactor2D") + keys(one.pose, one.landmark) + ", \"measurement\": {\"bearing\": " + bearing +
                   "}, \"range\": " + number(range.distance) + "}, \"covariance\": [" + number(1 / one.information) + ", 0, 0, " +
                   number(range.variance) + "]";
          } else {
            return of_matrix(one, edge);
          }
        },
        edge.measurement);
  }
  template <class V>
  std::string of_matrix(const RelativePoseEdge<V>& one, const Edge&) const {
    return std::string("\"type\": \"BetweenFactor") + V::name() + "\", " + keys(one.first, one.second) + ", \"measurement\": {" +
           value(one.measured, one.columns) + "}" + covariance<V::dim>(one.noise.converted(Format::PyFG, one.measured).written);
  }
  template <class V>
  std::string of_matrix(const PriorEdge<V>& one, const Edge&) const {
    return std::string("\"type\": \"PriorFactor") + V::name() + "\", \"key\": " + std::to_string(one.key.bits()) + ", \"prior\": {" +
           value(one.measured, one.columns) + "}" + covariance<V::dim>(one.noise.converted(Format::PyFG, one.measured).written);
  }
  template <class P>
  std::string of_matrix(const RelativePointEdge<P>&, const Edge& edge) const {
    cannot_hold(describe(edge), "it has no landmark in the frame of a pose; write g2o or PyFG");
  }
  template <class P>
  std::string of_matrix(const PositionEdge<P>&, const Edge& edge) const {
    cannot_hold(describe(edge), "it has no prior on a position alone; write g2o");
  }
  const char* ends_of(const RangeEdge& one, const Edge& edge) const {
    const auto first = types_.find(one.first), second = types_.find(one.second);
    if (first != types_.end() && second != types_.end()) {
      if (first->second == 0 && second->second == 0) return "Pose2";
      if (first->second == 1 && second->second == 1) return "Pose3";
      if (first->second == 0 && second->second == 2) return "2D";
      if (first->second == 1 && second->second == 3) return "3D";
    }
    cannot_hold(describe(edge), "its ranges go from a pose to a pose or to a point, both with a value");
  }

  const Dataset& dataset_;
  std::map<Key, std::size_t> types_;
  std::map<Key, char> owners_;
};

}  // namespace

Dataset parse_jrl(std::string_view text, const std::string& name) { return Reader(text, name).read(); }

std::vector<Vertex> parse_jrl_truth(std::string_view text, const std::string& name) { return Reader(text, name).read_truth(); }

std::string to_jrl(const Dataset& dataset) { return Writer(dataset).write(); }

void write_jrl(const std::string& path, const Dataset& dataset) { atomic_write(path, to_jrl(dataset)); }

bool is_of_jrl(const UnknownLine& line) {
  const std::size_t first = std::min(line.text.find_first_not_of(" \t"), line.text.size());
  return line.text.compare(first, line.tag.size(), line.tag) != 0;  // a line of another format begins with its tag
}

}  // namespace holdfast
