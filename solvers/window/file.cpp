#include <algorithm>
#include <holdfast/graph/files/atomic.hpp>
#include <holdfast/graph/files/binary.hpp>
#include <holdfast/graph/files/detail/sealed.hpp>
#include <holdfast/solvers/window/window.hpp>

namespace holdfast {
namespace {

// Version 2 was 0.1.0: agents were letters, factors raw bytes; 3 forgot what a lock remembers.
constexpr io::FileKind kKind{"holdfast window\n", 4, "a holdfast window",
                             "start a new window, or go on with the program that saved it (2: holdfast 0.1.0)"};

// ---- what an agent that keeps lock remembers

void put(io::ByteWriter& out, FactorId id) { out.put<std::int32_t>(id.number).put<std::uint32_t>(id.generation); }
FactorId get_id(io::ByteReader& in) {
  FactorId id;
  id.number = in.get<std::int32_t>();
  id.generation = in.get<std::uint32_t>();
  return id;
}

void write_lock(io::ByteWriter& out, const detail::Lock& lock) {
  io::write_binary(out, lock.memory, lock.values);
  out.put<std::uint64_t>(lock.left.size());
  for (const auto& left : lock.left) out.put(left.key).put(left.time);
  out.put<std::uint64_t>(lock.measured.size());
  for (const auto& one : lock.measured) {
    out.put(one.state);
    put(out, one.id);
    put(out, one.copy);
  }
  out.put<std::uint64_t>(lock.fresh).put<std::int32_t>(lock.states).put<std::int32_t>(lock.next_acquisition);
  out.put(lock.is_new).put(lock.is_unplaced);
  put(out, lock.prior);
}

/// With the options and the prior knowledge of `mine`.
std::unique_ptr<detail::Lock> read_lock(io::ByteReader& in, const detail::Lock& mine) {
  auto lock = std::make_unique<detail::Lock>(mine.options, mine.nothing_known);
  io::read_binary(in, lock->memory, lock->values);
  for (std::size_t count = in.get_count(sizeof(double)); count > 0; --count) {
    const Key key = in.get_key();
    lock->values.slot(key);
    lock->left.push_back({key, in.get<double>()});
  }
  for (std::size_t count = in.get_count(sizeof(std::uint64_t)); count > 0; --count) {
    const Key state = in.get_key();
    const FactorId id = get_id(in), copy = get_id(in);
    lock->measured.push_back({state, id, copy});
  }
  lock->fresh = in.get<std::uint64_t>();
  if (lock->fresh > lock->measured.size())
    fail<BadFile>("a step has seen ", lock->fresh, " of the ", lock->measured.size(), " measurements that an agent remembers");
  lock->states = in.get<std::int32_t>();
  lock->next_acquisition = in.get<std::int32_t>();
  lock->is_new = in.get<bool>();
  lock->is_unplaced = in.get<bool>();
  lock->prior = get_id(in);
  return lock;
}

}  // namespace

void Window::save(const std::string& path, std::string_view note) const {
  io::ByteWriter out;
  io::write_binary(out, graph_, values_);
  out.put(newest_).put(note);
  out.put<std::uint64_t>(members_.size());
  for (const Member& member : members_) write(out, member);
  atomic_write(path, io::sealed(kKind, out.bytes()));
}

void Window::write(io::ByteWriter& out, const Member& member) const {
  out.put(member.agent.bits()).put(std::string_view(member.motion ? member.motion->name() : "")).put(member.next_step);
  out.put<std::uint64_t>(member.states.size());
  for (const State& state : member.states) {
    const Graph::Place place = state.motion.number >= 0 ? graph_.place(state.motion) : Graph::Place{};
    out.put(state.key).put(state.time).put<std::int32_t>(place.batch).put<std::int32_t>(place.index);
  }
  out.put(member.lock != nullptr);
  if (member.lock) write_lock(out, *member.lock);
}

/// A member of the file's window, whose graph and values these are.
Window::Member Window::read_member(io::ByteReader& in, const Graph& graph, const Values& values) const {
  Member member{Agent::from_bits(in.get<std::uint32_t>()), nullptr, {}, 0, nullptr};
  const std::string motion = in.get_text();
  const Member* const mine = find(member.agent);
  const std::string my_motion = mine != nullptr && mine->motion ? mine->motion->name() : "";
  if (my_motion != motion)
    fail<BadFile>("its agent ", member.agent, " moves by ", motion.empty() ? "odometry" : motion, ", here by ",
                  my_motion.empty() ? "odometry" : my_motion, "; add_agent() the same as when it was saved");
  member.next_step = in.get<std::uint64_t>();
  for (std::size_t states = in.get_count(sizeof(double)); states > 0; --states) {
    const Key key = in.get_key();
    const auto time = in.get<double>();
    const auto batch = in.get<std::int32_t>(), index = in.get<std::int32_t>();
    values.slot(key);
    if (batch >= static_cast<int>(graph.batches().size()) || (batch >= 0 && (index < 0 || index >= graph.batches()[batch]->size())))
      fail<BadFile>("a state's motion is factor ", index, " of batch ", batch, ", which it does not hold");
    member.states.push_back({key, time, batch >= 0 ? graph.id_of(batch, index) : FactorId{}});
  }
  const bool keeps_lock = in.get<bool>(), kept_here = mine != nullptr && mine->lock;
  if (keeps_lock != kept_here)
    fail<BadFile>("its agent ", member.agent, keeps_lock ? " keeps lock, here it does not" : " keeps no lock, here it does",
                  "; call keep_lock() as when it was saved");
  if (keeps_lock) member.lock = read_lock(in, *mine->lock);
  return member;
}

std::string Window::restore(const std::string& path) {
  try {
    const std::string payload = io::read_sealed(kKind, path);
    io::ByteReader in(payload);
    Graph graph;
    Values values;
    io::read_binary(in, graph, values);
    const auto newest = in.get<double>();
    std::string note = in.get_text();
    std::vector<Member> members;
    for (std::size_t count = in.get_count(1); count > 0; --count) {
      Member member = read_member(in, graph, values);
      if (std::any_of(members.begin(), members.end(), [&](const Member& m) { return m.agent == member.agent; }))
        fail<BadFile>("it holds agent ", member.agent, " twice");
      members.push_back(std::move(member));
    }
    for (const Member& mine : members_) {  // that joined after the save
      if (!mine.motion || std::any_of(members.begin(), members.end(), [&](const Member& m) { return m.agent == mine.agent; })) continue;
      members.push_back({mine.agent, nullptr, {}, 0, nullptr});
      if (mine.lock) members.back().lock = std::make_unique<detail::Lock>(mine.lock->options, mine.lock->nothing_known);
    }
    for (Member& member : members)  // nothing can fail from here on
      if (Member* const mine = find(member.agent)) member.motion = std::move(mine->motion);
    members_ = std::move(members);
    graph_ = std::move(graph);
    values_ = std::move(values);
    newest_ = newest;
    step_ = {};
    return note;
  } catch (const Error& error) {
    fail<BadFile>("cannot resume from ", path, ": ", error.what());
  }
}

}  // namespace holdfast
