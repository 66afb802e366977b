// A smoother on disk, and back.
#include <algorithm>
#include <holdfast/graph/files/atomic.hpp>
#include <holdfast/graph/files/binary.hpp>
#include <holdfast/graph/files/detail/sealed.hpp>
#include <holdfast/solvers/incremental/internal/incremental_state.hpp>

namespace holdfast {
namespace {

constexpr io::FileKind kKind{"holdfast incremental\n", 1, "a holdfast incremental smoother",
                             "start a new one from its graph and values, or go on with the program that saved it"};

}  // namespace

void Incremental::save(const std::string& path, std::string_view note) const {
  const State& s = *state_;
  io::ByteWriter out;
  io::write_binary(out, graph_, start_);
  s.tree.write(out);
  out.put(note).put(s.work).put(s.whole);
  std::vector<std::int32_t> numbers;  // of the variables in their order; −1: fixed, −2: not entered yet
  for (const Key key : start_.keys()) {
    const auto it = s.variables.find(key);
    numbers.push_back(it == s.variables.end() ? State::kNew : it->second.number);
  }
  std::vector<int> far(s.far.begin(), s.far.end());
  std::sort(far.begin(), far.end());
  out.put(numbers).put(s.term_of).put(far);
  std::vector<std::uint64_t> keys;
  for (const Key key : new_keys_) keys.push_back(key.bits());
  out.put(keys).put<std::uint64_t>(s.new_factors.size());
  for (const FactorId id : s.new_factors) out.put<std::int32_t>(id.number).put<std::uint32_t>(id.generation);
  atomic_write(path, io::sealed(kKind, out.bytes()));
}

std::string Incremental::restore(const std::string& path) {
  try {
    const std::string payload = io::read_sealed(kKind, path);
    io::ByteReader in(payload);
    Incremental read(options_);
    io::read_binary(in, read.graph_, read.start_);
    std::string note = read.read_state(in);
    *this = std::move(read);
    return note;
  } catch (const Error& error) {
    fail<BadFile>("cannot resume from ", path, ": ", error.what());
  }
}

/// All but the graph and the values, which these bytes go with.
std::string Incremental::read_state(io::ByteReader& in) {
  const auto require = [](bool claim, const char* what) {
    if (!claim) fail<BadFile>("its ", what, " is not one of its graph");
  };
  State& s = *state_;
  s.tree = detail::CliqueTree::read(in);
  std::string note = in.get_text();
  s.work = in.get<double>();
  s.whole = in.get<double>();
  const auto numbers = in.get_list<std::int32_t>();
  s.term_of = in.get_list<int>();
  const auto far = in.get_list<int>();
  s.far.insert(far.begin(), far.end());

  const std::vector<Key> keys = start_.keys();
  require(numbers.size() == keys.size(), "list of variables");
  s.key_of.resize(static_cast<std::size_t>(s.tree.variables()));
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (numbers[i] == State::kNew) continue;
    State::Variable& variable = s.variables[keys[i]];
    variable.slot = start_.slot(keys[i]);
    variable.dim = start_.pool(variable.slot.pool).dim();
    variable.number = numbers[i];
    if (numbers[i] < 0) {
      require(graph_.is_fixed(keys[i]), "constant");
      continue;
    }
    require(numbers[i] < s.tree.variables() && s.tree.dim(numbers[i]) == variable.dim, "variable");
    s.key_of[numbers[i]] = keys[i];
  }
  for (const int number : far) require(number >= 0 && number < s.tree.variables() && s.variables.count(s.key_of[number]) != 0, "variable");
  for (auto count = in.get_count(sizeof(std::uint64_t)); count > 0; --count) {
    const Key key = in.get_key();
    require(start_.contains(key), "new variable");
    new_keys_.push_back(key);
  }
  for (auto count = in.get_count(sizeof(std::uint64_t)); count > 0; --count) {
    FactorId id;
    id.number = in.get<std::int32_t>();
    id.generation = in.get<std::uint32_t>();
    require(graph_.contains(id), "new factor");
    s.new_factors.push_back(id);
  }
  find_factors();
  return note;
}

/// Which variables each factor of the graph is on, and which term of the tree it is.
void Incremental::find_factors() {
  State& s = *state_;
  s.index.resize(graph_.batches().size());
  s.factor_of.resize(static_cast<std::size_t>(s.tree.terms()));
  for (std::size_t b = 0; b < graph_.batches().size(); ++b) {
    const FactorBatch& batch = *graph_.batches()[b];
    for (int i = 0; i < batch.size(); ++i) {
      std::vector<int> on;  // the tree's variables
      for (int k = 0; k < batch.arity(); ++k) {
        const Key key = batch.keys(i)[k];
        const Values::Slot& slot = start_.slot(key);
        if (start_.pool(slot.pool).type() != batch.types()[k]) fail<BadFile>(batch.describe(i), ": variable ", key, " is of another type");
        s.index[b].push_back(slot.index);
        if (const auto it = s.variables.find(key); it != s.variables.end() && it->second.number >= 0) on.push_back(it->second.number);
      }
      const FactorId id = graph_.id_of(static_cast<int>(b), i);
      if (static_cast<std::size_t>(id.number) >= s.term_of.size() || s.term_of[id.number] < 0) continue;
      const int term = s.term_of[id.number];
      if (term >= s.tree.terms() || s.tree.variables_of(term) != on) fail<BadFile>(batch.describe(i), ": its term is another factor's");
      s.factor_of[term] = id;
    }
  }
}

}  // namespace holdfast
