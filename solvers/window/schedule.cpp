#include <algorithm>
#include <cmath>
#include <holdfast/solvers/window/schedule.hpp>

namespace holdfast {
namespace {

bool arrived(Arrival arrival) { return arrival == Arrival::received || arrival == Arrival::rejected; }

}  // namespace

const char* to_string(Arrival arrival) {
  static const char* const names[] = {"received", "rejected", "dropped", "out of range"};
  return names[static_cast<int>(arrival)];
}

Stream::Stream(StreamEnd a, StreamEnd b, double first, double period) : a_(a), b_(b), first_(first), period_(period) {
  if (!(std::isfinite(period) && period > 0)) fail<BadNumber>("a stream of measurements: period = ", period, " must be finite and > 0 [s]");
  if (!std::isfinite(first)) fail<BadNumber>("a stream of measurements: first = ", first, " must be finite [s]");
}

std::int64_t Stream::number_at(double time) const {
  const double number = std::round((time - first_) / period_);
  if (!(number >= 0 && number < 9e15))
    fail<BadTime>("a measurement at ", time, " s was never expected: the first of its stream is due at ", first_, " s, one each ", period_,
                  " s");
  return static_cast<std::int64_t>(number);
}

void Stream::set(Entry& entry, Arrival arrival) {
  --counts_[static_cast<int>(entry.arrival)];
  entry.arrival = arrival;
  ++counts_[static_cast<int>(arrival)];
}

// What is older than the lag cannot change any more; the times of the states decide.
void Stream::forget_old(const Window& window) {
  const double cutoff = window.newest_time() - window.options().lag;
  while (!entries_.empty() && due(entries_.front().number) <= cutoff && !window.graph().contains(entries_.front().factor)) {
    moved_up();
    entries_.pop_front();
  }
}

std::size_t Stream::place(Window& window, std::int64_t number) {
  constexpr std::int64_t kMostAtOnce = 1'000'000;
  if (number >= next_ + kMostAtOnce)
    fail<BadTime>("a measurement due at ", due(number), " s is more than ", kMostAtOnce,
                  " periods ahead of the last one expected; repair the clock");
  for (; next_ <= number; ++next_) {
    ++counts_[static_cast<int>(Arrival::dropped)];
    entries_.push_back({next_, Arrival::dropped, {}});
    made_room();
    if (next_ == number || due(next_) <= window.newest_time() - window.options().lag) continue;
    entries_.back().factor = bound(window, entries_.size() - 1);
  }
  const auto it = std::lower_bound(entries_.begin(), entries_.end(), number, [](const Entry& e, std::int64_t n) { return e.number < n; });
  if (it == entries_.end() || it->number != number)
    fail<BadTime>("a measurement due at ", due(number), " s has left the window; leave it out, or choose a longer lag");
  return static_cast<std::size_t>(it - entries_.begin());
}

FactorId Stream::bound(Window& window, std::size_t i) {
  try {
    return add_missing(window, i);
  } catch (const BadTime&) {  // its agent was not there yet, or is elsewhere by now
    return {};
  } catch (const BadKey&) {
    return {};
  }
}

void Stream::refresh(Window& window, std::size_t i) {
  for (++i; i < entries_.size() && !arrived(entries_[i].arrival); ++i) {
    if (!window.graph().contains(entries_[i].factor)) continue;
    window.remove(entries_[i].factor);
    entries_[i].factor = bound(window, i);
  }
}

void Stream::lose(Window& window, double time, Arrival why) {
  if (arrived(why)) fail<BadOption>("lose(): '", to_string(why), "' is no loss; say dropped or out_of_range");
  const std::size_t i = place(window, number_at(time));
  if (arrived(entries_[i].arrival)) return;  // it did come
  set(entries_[i], why);
  if (!window.graph().contains(entries_[i].factor)) entries_[i].factor = bound(window, i);
}

void Stream::close(Window& window, double now) {
  const double last = std::floor((now - first_) / period_ + 1e-6);
  if (last >= static_cast<double>(next_)) {
    const std::size_t i = place(window, static_cast<std::int64_t>(last));
    if (!window.graph().contains(entries_[i].factor)) entries_[i].factor = bound(window, i);
  }
  forget_old(window);
}

void Stream::judge(const std::vector<MeasurementReport>& report) {
  for (const MeasurementReport& one : report)
    for (Entry& entry : entries_) {
      if (!arrived(entry.arrival) || entry.factor.number != one.id.number || entry.factor.generation != one.id.generation) continue;
      set(entry, one.verdict == MeasurementReport::Verdict::inlier ? Arrival::received : Arrival::rejected);
    }
}

void Stream::write(io::ByteWriter& out, const Graph& graph) const {
  out.put(first_).put(period_).put(next_);
  for (std::size_t count : counts_) out.put<std::uint64_t>(count);
  out.put<std::uint64_t>(entries_.size());
  for (const Entry& entry : entries_) {
    const Graph::Place place = graph.contains(entry.factor) ? graph.place(entry.factor) : Graph::Place{};
    out.put(entry.number).put(static_cast<std::int32_t>(entry.arrival)).put<std::int32_t>(place.batch).put<std::int32_t>(place.index);
  }
  write_measurements(out);
}

void Stream::read(io::ByteReader& in, const Graph& graph) {
  if (in.get<double>() != first_ || in.get<double>() != period_) fail<BadFile>("the schedule saved has other streams; expect() the same");
  next_ = in.get<std::int64_t>();
  for (std::size_t& count : counts_) count = in.get<std::uint64_t>();
  entries_.clear();
  for (std::size_t count = in.get_count(sizeof(std::int64_t)); count > 0; --count) {
    Entry entry{in.get<std::int64_t>(), static_cast<Arrival>(in.get<std::int32_t>()), {}};
    const auto batch = in.get<std::int32_t>(), index = in.get<std::int32_t>();
    if (batch >= static_cast<int>(graph.batches().size()) || (batch >= 0 && index >= graph.batches()[batch]->size()))
      fail<BadFile>("the schedule saved is of another window");
    if (batch >= 0) entry.factor = graph.id_of(batch, index);
    entries_.push_back(entry);
  }
  read_measurements(in);
}

Stream& Schedule::known(const AnyStreamId& id) const {
  if (id.schedule_ != this) fail<BadKey>("a stream of another schedule, or of none; give what expect() of this one returned");
  return *streams_[id.number_];
}

std::string Schedule::save() const {
  io::ByteWriter out;
  out.put<std::uint64_t>(streams_.size());
  for (const auto& stream : streams_) stream->write(out, window_.graph());
  return out.bytes();
}

void Schedule::restore(std::string_view bytes) {
  io::ByteReader in(bytes);
  if (in.get<std::uint64_t>() != streams_.size())
    fail<BadFile>("the schedule saved has another number of streams than the ", streams_.size(), " here");
  for (auto& stream : streams_) stream->read(in, window_.graph());
}

}  // namespace holdfast
