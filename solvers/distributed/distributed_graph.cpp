#include <algorithm>
#include <holdfast/graph/files/binary.hpp>
#include <holdfast/solvers/backend.hpp>
#include <holdfast/solvers/distributed/internal/directory.hpp>
#include <holdfast/solvers/distributed/internal/distributed_problem.hpp>
#include <map>

namespace holdfast {

struct DistributedGraph::Parts {
  Communicator communicator;
  Graph graph;
  Values values;
  std::vector<int> own_variables;  // of each pool: they come first
  std::vector<int> own_factors;    // of each batch: they come first
  std::size_t own_factor_count, own_variable_count;
  std::vector<Key> held;  // ghosts that are not fixed by their owners
  detail::Exchange exchange;
  std::uint32_t job = 0;

  Parts(Communicator among, Graph factors, Values own)
      : communicator(among),
        graph(std::move(factors)),
        values(std::move(own)),
        own_factor_count(graph.size()),
        own_variable_count(values.size()) {
    for (const auto& pool : values.pools()) own_variables.push_back(pool->size());
    for (const auto& batch : graph.batches()) own_factors.push_back(batch->size());
  }

  bool is_own(Key key) const {
    if (!values.contains(key)) return false;
    const Values::Slot& slot = values.slot(key);
    return slot.pool < static_cast<int>(own_variables.size()) && slot.index < own_variables[slot.pool];
  }

  // ---- construction

  std::map<int, detail::Exchange::Neighbour> links;

  /// The keys of these factors that are not here, each once.
  std::vector<Key> absent_keys(const Graph& of) const {
    std::vector<Key> keys;
    for (const auto& batch : of.batches())
      for (int i = 0; i < batch->size(); ++i)
        for (int k = 0; k < batch->arity(); ++k)
          if (!values.contains(batch->keys(i)[k])) keys.push_back(batch->keys(i)[k]);
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    return keys;
  }

  std::string describe_factor_on(const Graph& of, Key key) const {
    for (const auto& batch : of.batches())
      for (int i = 0; i < batch->size(); ++i)
        if (std::find(batch->keys(i), batch->keys(i) + batch->arity(), key) != batch->keys(i) + batch->arity()) return batch->describe(i);
    return "";
  }

  /// Makes ghosts of these keys, and remembers who is to send them what from now on.
  void fetch(const std::vector<Key>& keys, const detail::Directory& directory, const Graph& wanted_by) {
    const std::vector<int> owners = directory.owners(keys);
    std::vector<std::vector<Key>> wanted(communicator.size());
    communicator.agree([&] {
      for (std::size_t i = 0; i < keys.size(); ++i) {
        if (owners[i] < 0)
          fail<BadKey>("no process has the variable ", keys[i], ", which the factor ", describe_factor_on(wanted_by, keys[i]), " names");
        wanted[owners[i]].push_back(keys[i]);
      }
    });
    std::vector<std::string> questions;
    for (const std::vector<Key>& list : wanted) {
      io::ByteWriter out;
      for (Key key : list) out.put(key);
      questions.push_back(out.bytes());
    }
    const std::vector<std::string> asked = communicator.exchange(questions);
    std::vector<std::string> answers;
    for (int rank = 0; rank < communicator.size(); ++rank) answers.push_back(answer(rank, asked[rank]));
    const std::vector<std::string> answered = communicator.exchange(answers);
    for (int rank = 0; rank < communicator.size(); ++rank) take(rank, wanted[rank], answered[rank]);
  }

  std::string answer(int rank, const std::string& question) {
    io::ByteWriter out;
    for (io::ByteReader in(question); !in.at_end();) {
      const Key key = in.get_key();
      const Values::Slot slot = values.slot(key);
      const PoolBase& pool = values.pool(slot.pool);
      const bool fixed = graph.is_fixed(key);
      out.put(std::string_view(pool.type_name())).put(fixed).put(pool.data(slot.index), sizeof(double) * pool.ambient());
      if (!fixed) links[rank].own.push_back(slot);
    }
    return out.bytes();
  }

  void take(int rank, const std::vector<Key>& keys, const std::string& bytes) {
    io::ByteReader in(bytes);
    for (Key key : keys) {
      const PoolBase& type = *find_variable_type(in.get_text());
      const bool fixed = in.get_bool();
      std::vector<double> x(type.ambient());
      std::memcpy(x.data(), in.take(sizeof(double) * x.size()), sizeof(double) * x.size());
      values.insert_ambient(key, type, x.data());
      if (fixed) {
        graph.fix(key);
      } else {
        held.push_back(key);
        links[rank].ghosts.push_back(values.slot(key));
      }
    }
  }

  void require_fixed_are_own() const {
    for (Key key : graph.fixed())
      if (!values.contains(key)) fail<BadKey>("the variable ", key, " is fixed by a process that does not have it; its owner fixes it");
  }
};

namespace {

/// Parts of the graph for each process: the factors on free variables that it owns.
std::vector<std::string> copies_for_owners(const Graph& graph, const Values& values, const std::unordered_map<Key, int>& owner_of,
                                           int size) {
  std::vector<Graph> copies(size);
  std::vector<Values> their_values(size);
  for (std::size_t b = 0; b < graph.batches().size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    for (int i = 0; i < batch.size(); ++i) {
      const Key *first = batch.keys(i), *last = first + batch.arity();
      std::vector<int> owners;
      for (const Key* key = first; key != last; ++key)
        if (const auto owner = owner_of.find(*key); owner != owner_of.end()) owners.push_back(owner->second);
      std::sort(owners.begin(), owners.end());
      owners.erase(std::unique(owners.begin(), owners.end()), owners.end());
      for (int rank : owners) {
        copies[rank].add_from(graph, graph.id_of(static_cast<int>(b), i));
        for (const Key* key = first; key != last; ++key) {
          if (their_values[rank].contains(*key)) continue;
          const Values::Slot slot = values.slot(*key);
          their_values[rank].insert_ambient(*key, values.pool(slot.pool).kind(), values.pool(slot.pool).data(slot.index));
        }
      }
    }
  }
  std::vector<std::string> bytes;
  for (int rank = 0; rank < size; ++rank) {
    io::ByteWriter out;
    if (copies[rank].size() > 0) io::write_binary(out, copies[rank], their_values[rank]);
    bytes.push_back(out.bytes());
  }
  return bytes;
}

}  // namespace

DistributedGraph::DistributedGraph(Communicator communicator, Graph factors, Values own)
    : parts_(std::make_unique<Parts>(communicator, std::move(factors), std::move(own))) {
  Parts& p = *parts_;
  const Communicator& all = p.communicator;
  const detail::Directory directory(all, p.values.keys());
  const std::vector<Key> named = p.absent_keys(p.graph);
  all.agree([&] { p.require_fixed_are_own(); });
  if (all.sum(static_cast<std::int64_t>(p.graph.size())) == 0) fail<BadProblem>("no process has a factor; add measurements before solving");
  p.fetch(named, directory, p.graph);

  std::vector<Graph> copies(all.size());
  std::vector<std::string> bytes;
  std::unordered_map<Key, int> owner_of;  // of the ghosts that are free
  const std::vector<int> owners = directory.owners(p.held);
  for (std::size_t i = 0; i < p.held.size(); ++i) owner_of[p.held[i]] = owners[i];
  all.agree([&] { bytes = copies_for_owners(p.graph, p.values, owner_of, all.size()); });
  bytes = all.exchange(bytes);
  Graph others;
  all.agree([&] {
    for (int rank = 0; rank < all.size(); ++rank) {
      if (bytes[rank].empty()) continue;
      Values unused;
      io::ByteReader in(bytes[rank]);
      io::read_binary(in, copies[rank], unused);
    }
  });
  for (const Graph& from : copies)
    for (std::size_t b = 0; b < from.batches().size(); ++b)
      for (int i = 0; i < from.batches()[b]->size(); ++i) others.add_from(from, from.id_of(static_cast<int>(b), i));
  p.fetch(p.absent_keys(others), directory, others);
  for (std::size_t b = 0; b < others.batches().size(); ++b)
    for (int i = 0; i < others.batches()[b]->size(); ++i) p.graph.add_from(others, others.id_of(static_cast<int>(b), i));
  p.own_factors.resize(p.graph.batches().size(), 0);

  std::vector<detail::Exchange::Neighbour> neighbours;
  for (auto& [rank, link] : p.links) {
    link.rank = rank;
    neighbours.push_back(std::move(link));
  }
  p.links.clear();
  p.exchange = detail::Exchange(std::move(neighbours));
  all.agree([&] { Resolved(p.graph, p.values); });
}

DistributedGraph::~DistributedGraph() = default;
DistributedGraph::DistributedGraph(DistributedGraph&&) noexcept = default;
DistributedGraph& DistributedGraph::operator=(DistributedGraph&&) noexcept = default;

const Communicator& DistributedGraph::communicator() const { return parts_->communicator; }
Values& DistributedGraph::values() { return parts_->values; }
const Values& DistributedGraph::values() const { return parts_->values; }
const Graph& DistributedGraph::graph() const { return parts_->graph; }
bool DistributedGraph::is_own(Key key) const { return parts_->is_own(key); }
std::size_t DistributedGraph::own_factors() const { return parts_->own_factor_count; }
std::size_t DistributedGraph::own_variables() const { return parts_->own_variable_count; }
std::size_t DistributedGraph::ghosts() const { return parts_->values.size() - parts_->own_variable_count; }

std::vector<int> DistributedGraph::neighbours() const {
  std::vector<int> ranks;
  for (const auto& neighbour : parts_->exchange.neighbours()) ranks.push_back(neighbour.rank);
  return ranks;
}

std::size_t DistributedGraph::boundary_numbers() const {
  std::size_t numbers = 0;
  for (const auto& neighbour : parts_->exchange.neighbours())
    for (const Values::Slot& slot : neighbour.own) numbers += parts_->values.pool(slot.pool).ambient();
  return numbers;
}

std::uint32_t DistributedGraph::job() const { return parts_->job; }
void DistributedGraph::set_job(std::uint32_t number) { parts_->job = number; }

double DistributedGraph::cost() {
  detail::DistributedProblem problem(*this, false);
  problem.update(parts_->values);
  return problem.cost(parts_->values, nullptr);
}

std::int64_t DistributedGraph::total_factors() const {
  return parts_->communicator.sum(static_cast<std::int64_t>(parts_->own_factor_count));
}
std::int64_t DistributedGraph::total_variables() const {
  return parts_->communicator.sum(static_cast<std::int64_t>(parts_->own_variable_count));
}

namespace detail {

DistributedProblem::DistributedProblem(DistributedGraph& graph, bool ghosts_are_constants)
    : communicator_(&graph.parts_->communicator),
      graph_(&graph.parts_->graph),
      values_(&graph.parts_->values),
      exchange_(&graph.parts_->exchange),
      own_variables_(graph.parts_->own_variables),
      own_factors_(graph.parts_->own_factors) {
  for (Key key : graph.parts_->held)
    if (graph.parts_->graph.is_fixed(key) != ghosts_are_constants)
      ghosts_are_constants ? graph.parts_->graph.fix(key) : graph.parts_->graph.unfix(key);
  finish();
}

DistributedProblem::DistributedProblem(const Graph& graph, Values& values)
    : alone_(std::make_unique<Communicator>(Communicator::alone())),
      nobody_(std::make_unique<Exchange>()),
      communicator_(alone_.get()),
      graph_(&graph),
      values_(&values),
      exchange_(nobody_.get()) {
  for (const auto& pool : values.pools()) own_variables_.push_back(pool->size());
  for (const auto& batch : graph.batches()) own_factors_.push_back(batch->size());
  finish();
}

void DistributedProblem::finish() {
  communicator_->agree([&] { resolved_.rebuild(*graph_, *values_); });
  std::int64_t own = 0;
  for (const Resolved::Variable& v : resolved_.variables())
    if (v.offset >= 0 && owns(v)) own += v.dim;
  total_tangent_dim_ = communicator_->sum(own);
  if (total_tangent_dim_ == 0) fail<BadProblem>("every variable that a factor touches is fixed; there is nothing to solve for");
}

double DistributedProblem::own_cost(const Values& values, ThreadPool* pool) const {
  constexpr int kFactorsPerChunk = 512;
  std::vector<Chunk> chunks;
  for (std::size_t b = 0; b < own_factors_.size(); ++b)
    for (int first = 0; first < own_factors_[b]; first += kFactorsPerChunk)
      chunks.push_back({static_cast<int>(b), first, std::min(own_factors_[b], first + kFactorsPerChunk)});
  std::vector<double> parts(chunks.size());
  parallel_for(pool, static_cast<int>(chunks.size()), [&](int c) {
    const Chunk& chunk = chunks[c];
    parts[c] = graph_->batches()[chunk.batch]->cost(values, resolved_.batches()[chunk.batch].index.data(), chunk.first, chunk.last);
  });
  double sum = 0;
  for (double part : parts) sum += part;
  return sum;
}

double DistributedProblem::cost(const Values& values, ThreadPool* pool) const { return communicator_->sum(own_cost(values, pool)); }

std::string DistributedProblem::first_non_finite(const Values& values) const {
  std::string text = resolved_.first_non_finite(*graph_, values).text;
  if (communicator_->size() > 1 && !text.empty()) text = "process " + std::to_string(communicator_->rank()) + ": " + text;
  return text;
}

}  // namespace detail
}  // namespace holdfast
