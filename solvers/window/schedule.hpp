// Missing data as an object: which measurements were expected, and what became of each.
//
//   Schedule schedule(window);
//   const auto ranges = schedule.expect<Range<Motion2, Point2>>('A', L(0), t0, 0.1,                       // one each 0.1 s from t0 on
//       [](const auto& last, int m) { return MissingDistance<Motion2, Point2>{last.distance, last.sigma, 0.3 * std::sqrt(m)}; });
//   schedule.receive(ranges, t, Range<Motion2, Point2>{12.3, 0.5}, Huber{2});
//   schedule.lose(ranges, t, Arrival::out_of_range);            // known to be missing
//   schedule.close(now);                                        // what has not come by now is dropped
//   schedule.judge(window.step(now).report);                    // what its loss does not believe is rejected
//
// A measurement that is missing says either nothing (then a state that carries nothing else becomes part of a longer motion), or what
// make(last, m) says: a factor from the last one that arrived, m >= 1 measurements before. With ρ√m it is a random walk of the distance.
// One that arrives after all takes its place, and those missing after it are made again from it. One refused by the window (BadTime: it is
// older than the lag) changes nothing.
#pragma once

#include <deque>
#include <holdfast/graph/files/binary.hpp>
#include <holdfast/solvers/window/window.hpp>

namespace holdfast {

enum class Arrival : int { received, rejected, dropped, out_of_range };
const char* to_string(Arrival arrival);

/// One end of a measurement: an agent at the time of the measurement, or a landmark.
struct StreamEnd {
  std::optional<Agent> agent;  ///< none: the landmark
  Key landmark;
  StreamEnd(char kind) : agent(kind) {}
  StreamEnd(Agent moving) : agent(moving) {}
  StreamEnd(Key key) : landmark(key) {}
};

/// Measurements of one kind between the same two ends, one each `period` [s] from `first` [s] on.
class Stream {
 public:
  virtual ~Stream() = default;
  struct Entry {
    std::int64_t number;  ///< due at first + number · period
    Arrival arrival;
    FactorId factor;  ///< number −1: none
  };
  const std::deque<Entry>& entries() const { return entries_; }  ///< of those whose states may be in the window, oldest first
  std::size_t count(Arrival arrival) const { return counts_[static_cast<int>(arrival)]; }  ///< since the beginning

  void lose(Window& window, double time, Arrival why);
  void close(Window& window, double now);
  void judge(const std::vector<MeasurementReport>& report);
  void write(io::ByteWriter& out, const Graph& graph) const;
  void read(io::ByteReader& in, const Graph& graph);

 protected:
  Stream(StreamEnd a, StreamEnd b, double first, double period);
  std::int64_t number_at(double time) const;
  double due(std::int64_t number) const { return first_ + static_cast<double>(number) * period_; }
  Key key_of(Window& window, const StreamEnd& end, double time) const { return end.agent ? window.at(*end.agent, time) : end.landmark; }
  /// The entry of this number, dropped as yet where it is new; those before it that are not there are dropped, too.
  std::size_t place(Window& window, std::int64_t number);
  void set(Entry& entry, Arrival arrival);
  void forget_old(const Window& window);
  /// Makes the missing ones after entry i again, up to the next that arrived.
  void refresh(Window& window, std::size_t i);
  /// add_missing(), or nothing where the window has no place for it.
  FactorId bound(Window& window, std::size_t i);
  virtual FactorId add_missing(Window& window, std::size_t i) = 0;
  virtual void moved_up() = 0;   ///< the first entry leaves
  virtual void made_room() = 0;  ///< an entry was appended
  virtual void write_measurements(io::ByteWriter& out) const = 0;
  virtual void read_measurements(io::ByteReader& in) = 0;

  StreamEnd a_, b_;
  double first_, period_;
  std::deque<Entry> entries_;
  std::int64_t next_ = 0;  ///< the first number that has no entry yet
  std::array<std::size_t, 4> counts_{};
};

/// Takes measurements of type F.
template <class F>
struct Receiver {
  virtual ~Receiver() = default;
  virtual void receive(Window& window, double time, const F& factor, const Loss& loss) = 0;
};

template <class F, class Make>
class StreamOf final : public Stream, public Receiver<F> {
  static_assert(F::Variables::size == 2, "a stream is of measurements between two variables");

 public:
  StreamOf(StreamEnd a, StreamEnd b, double first, double period, Make make) : Stream(a, b, first, period), make_(std::move(make)) {}

  void receive(Window& window, double time, const F& factor, const Loss& loss) override {
    const std::int64_t number = number_at(time);
    const FactorId id = window.add(factor, {key_of(window, a_, time), key_of(window, b_, time)}, loss);  // or it is refused
    const std::size_t i = place(window, number);
    if (window.graph().contains(entries_[i].factor)) window.remove(entries_[i].factor);
    set(entries_[i], Arrival::received);
    entries_[i].factor = id;
    measurements_[i] = factor;
    refresh(window, i);
  }

 private:
  static constexpr bool kSilent = std::is_same_v<Make, std::nullptr_t>;

  FactorId add_missing(Window& window, std::size_t i) override {
    if constexpr (!kSilent) {
      std::size_t last = i;
      while (last > 0 && !measurements_[last - 1]) --last;
      const std::optional<F>& from = last > 0 ? measurements_[last - 1] : before_;
      if (!from) return {};
      const std::int64_t number = last > 0 ? entries_[last - 1].number : before_number_;
      const double time = due(entries_[i].number);
      return window.add(make_(*from, static_cast<int>(entries_[i].number - number)), {key_of(window, a_, time), key_of(window, b_, time)});
    } else {
      (void)window, (void)i;
      return {};
    }
  }
  void moved_up() override {
    if (measurements_.front()) {
      before_ = measurements_.front();
      before_number_ = entries_.front().number;
    }
    measurements_.pop_front();
  }
  void made_room() override { measurements_.emplace_back(); }

  // In a file a measurement is its fields by name (graph/fields.hpp): a program whose measurement has others refuses it.
  static constexpr bool kIsSaved = detail::HasFields<F>::value && std::is_default_constructible_v<F>;

  static std::string fields() {
    if constexpr (kIsSaved) return detail::types_of_fields<F>();
    fail<BadOption>("a schedule of ", factor_name<F>(),
                    " cannot be saved: it has no fields() (graph/fields.hpp), or no default constructor");
  }
  static void write(io::ByteWriter& out, const std::optional<F>& factor) {
    out.put(factor.has_value());
    if constexpr (kIsSaved) {
      if (!factor) return;
      char bytes[detail::field_bytes<F>()];
      char* end = bytes;
      detail::put_field(*factor, end);
      out.put(bytes, sizeof bytes);
    }
  }
  static std::optional<F> read_one(io::ByteReader& in) {
    if constexpr (kIsSaved) {
      if (!in.get<bool>()) return std::nullopt;
      F factor{};
      const char* bytes = in.take(detail::field_bytes<F>());
      detail::get_field(factor, bytes);
      return factor;
    }
    return std::nullopt;
  }
  void write_measurements(io::ByteWriter& out) const override {
    out.put(std::string_view(fields()));
    write(out, before_);
    out.put(before_number_);
    for (const std::optional<F>& factor : measurements_) write(out, factor);
  }
  void read_measurements(io::ByteReader& in) override {
    const std::string saved = in.get_text();
    if (saved != fields()) fail<BadFile>("the schedule saved has measurements of {", saved, "}, here they are of {", fields(), "}");
    before_ = read_one(in);
    before_number_ = in.get<std::int64_t>();
    measurements_.clear();
    for (std::size_t i = 0; i < entries_.size(); ++i) measurements_.push_back(read_one(in));
  }

  Make make_;
  std::deque<std::optional<F>> measurements_;  ///< of each entry; none: missing
  std::optional<F> before_;                    ///< the last that arrived before the first entry
  std::int64_t before_number_ = 0;
};

class Schedule;

/// Names one stream of one schedule.
class AnyStreamId {
 public:
  AnyStreamId() = default;  ///< of no stream

 private:
  friend class Schedule;
  const Schedule* schedule_ = nullptr;
  int number_ = -1;
};
/// The same, and that its measurements are of type F: what expect<F>() returns.
template <class F>
class StreamId : public AnyStreamId {
 public:
  using Measurement = F;
};

class Schedule {
 public:
  /// The window must live as long.
  explicit Schedule(Window& window) : window_(window) {}
  Schedule(const Schedule&) = delete;  // its streams are named by where it is
  Schedule& operator=(const Schedule&) = delete;

  /// A stream of measurements F. make(last, m): see above; none: a missing measurement says nothing. Throws BadNumber (period).
  template <class F, class Make = std::nullptr_t>
  StreamId<F> expect(StreamEnd a, StreamEnd b, double first, double period, Make make = {}) {
    streams_.push_back(std::make_unique<StreamOf<F, Make>>(a, b, first, period, std::move(make)));
    StreamId<F> id;
    id.schedule_ = this;
    id.number_ = static_cast<int>(streams_.size()) - 1;
    return id;
  }
  /// Throws BadKey (a stream of another schedule), BadTime (refused). A measurement of another type does not compile.
  template <class F>
  void receive(const StreamId<F>& id, double time, const typename StreamId<F>::Measurement& factor, const Loss& loss = {}) {
    dynamic_cast<Receiver<F>&>(known(id)).receive(window_, time, factor, loss);
  }
  void lose(const AnyStreamId& id, double time, Arrival why) { known(id).lose(window_, time, why); }
  void close(double now) {
    for (auto& stream : streams_) stream->close(window_, now);
  }
  void judge(const std::vector<MeasurementReport>& report) {
    for (auto& stream : streams_) stream->judge(report);
  }
  const Stream& stream(const AnyStreamId& id) const { return known(id); }

  /// For Window::save(path, note) and what restore() returns; into a schedule with the same streams, after the window. Throws BadFile.
  std::string save() const;
  void restore(std::string_view bytes);

 private:
  Stream& known(const AnyStreamId& id) const;

  Window& window_;
  std::vector<std::unique_ptr<Stream>> streams_;
};

}  // namespace holdfast
