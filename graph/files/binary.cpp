#include <algorithm>
#include <holdfast/graph/files/binary.hpp>

namespace holdfast {
namespace io {

void ByteReader::require(std::size_t size) const {
  if (size > bytes_.size()) fail<BadFile>("the bytes end early");
}

const char* ByteReader::take(std::size_t size) {
  require(size);
  const char* from = bytes_.data();
  bytes_.remove_prefix(size);
  return from;
}

bool ByteReader::get_bool() {
  const auto byte = get<std::uint8_t>();
  if (byte > 1) fail<BadFile>("a truth value is ", int{byte}, ", neither 0 nor 1");
  return byte == 1;
}

std::string ByteReader::get_text() {
  const std::size_t size = get_count(1);
  return {take(size), size};
}

Key ByteReader::get_key() { return Key::from_bits(get<std::uint64_t>()); }

std::size_t ByteReader::get_count(std::size_t bytes) {
  const auto count = get<std::uint64_t>();
  if (count > bytes_.size() / bytes) fail<BadFile>("the bytes end early");
  return count;
}

}  // namespace io

/// Reaches into Graph and Values: a copy of their memory, in its order.
struct BinaryIo {
  static void write(io::ByteWriter& out, const Values& values) {
    out.put<std::uint64_t>(values.pools().size());
    for (const auto& pool : values.pools()) {
      out.put(std::string_view(pool->type_name())).put<std::int32_t>(pool->ambient()).put<std::uint64_t>(pool->size());
      for (int i = 0; i < pool->size(); ++i) out.put(pool->keys()[i]).put(std::as_const(*pool).data(i), sizeof(double) * pool->ambient());
    }
  }
  static const PoolBase& variable_type(const std::string& name, int ambient) {
    const PoolBase* type = find_variable_type(name);
    if (type == nullptr || type->ambient() != ambient)
      fail<BadFile>("it holds variables of type ", name, " (", ambient, " numbers), which this program does not insert");
    return *type;
  }
  static void read(io::ByteReader& in, Values& values) {
    for (std::size_t pools = in.get_count(1); pools > 0; --pools) {
      const std::string name = in.get_text();
      const PoolBase& type = variable_type(name, in.get<std::int32_t>());
      const int index = values.pool_of(type);
      for (std::size_t size = in.get_count(sizeof(std::uint64_t)); size > 0; --size) {
        const Key key = in.get_key();
        values.require_new(key);
        values.claim(key, index);
        values.pool(index).push_ambient(key, ambient(in, type.ambient()).data());
      }
    }
  }
  static std::vector<double> ambient(io::ByteReader& in, int size) {
    std::vector<double> x(size);
    std::memcpy(x.data(), in.take(sizeof(double) * x.size()), sizeof(double) * x.size());
    return x;
  }

  static void write(io::ByteWriter& out, const Graph& graph) {
    std::vector<Key> fixed(graph.fixed().begin(), graph.fixed().end());
    std::sort(fixed.begin(), fixed.end());
    out.put<std::uint64_t>(fixed.size());
    for (Key key : fixed) out.put(key);
    write_ids(out, graph);
    out.put<std::uint64_t>(graph.batches().size());
    for (const auto& batch : graph.batches()) write(out, *batch);
  }
  // The generation of each number, the free numbers, then the number of each factor in the batches' order.
  static void write_ids(io::ByteWriter& out, const Graph& graph) {
    out.put<std::uint64_t>(graph.places_.size());
    for (const Graph::Place& place : graph.places_) out.put<std::uint32_t>(place.generation);
    out.put<std::uint64_t>(graph.free_.size());
    for (int number : graph.free_) out.put<std::int32_t>(number);
    for (std::size_t b = 0; b < graph.batches().size(); ++b)
      for (int i = 0; i < graph.batches()[b]->size(); ++i) out.put<std::int32_t>(graph.id_of(static_cast<int>(b), i).number);
  }
  static void write(io::ByteWriter& out, const FactorBatch& batch) {
    const bool is_prior = batch.factor_type() == typeid(LinearPrior);
    const FactorType* type = find_factor_type(batch.factor_type());
    if (!is_prior && (type == nullptr || type->bytes == 0))
      fail<BadFile>("a factor ", batch.name(), " cannot be written: it owns memory, or was added by no code of this program");
    out.put(is_prior ? std::string_view("LinearPrior") : std::string_view(type->name)).put<std::uint64_t>(is_prior ? 0 : type->bytes);
    const Loss& loss = batch.loss();
    out.put(static_cast<std::int32_t>(loss.kind)).put(loss.scale).put(loss.per_component).put(loss.one_sided);
    out.put<std::uint64_t>(batch.size());
    for (int i = 0; i < batch.size(); ++i) {
      out.put(batch.weight(i));
      if (is_prior) {
        write(out, static_cast<const LinearPriorBatch&>(batch).prior());
        continue;
      }
      for (int k = 0; k < batch.arity(); ++k) out.put(batch.keys(i)[k]);
      out.put(type->at(batch, i), type->bytes);
    }
  }
  static void write(io::ByteWriter& out, const LinearPrior& prior) {
    out.put<std::uint64_t>(prior.keys.size());
    const double* x = prior.x0.data();
    for (std::size_t k = 0; k < prior.keys.size(); ++k) {
      const PoolBase& type = *prior.types[k];
      out.put(prior.keys[k])
          .put(std::string_view(type.type_name()))
          .put<std::int32_t>(type.ambient())
          .put(x, sizeof(double) * type.ambient());
      x += type.ambient();
    }
    out.put<std::int32_t>(prior.rows).put(prior.constant);
    out.put(prior.A.data(), sizeof(double) * prior.A.size()).put(prior.b.data(), sizeof(double) * prior.b.size());
  }

  static void read(io::ByteReader& in, Graph& graph) {
    for (std::size_t fixed = in.get_count(sizeof(std::uint64_t)); fixed > 0; --fixed) graph.fix(in.get_key());
    const std::vector<int> free = read_ids(in, graph);
    for (std::size_t batches = in.get_count(1); batches > 0; --batches) read_batch(in, graph);
    if (!graph.free_.empty()) fail<BadFile>("it names ", graph.free_.size(), " factors more than it holds");
    graph.free_ = free;
  }
  // Leaves the factors' numbers in graph.free_ so that enter() hands them out in the batches' order; returns the numbers that stay free.
  static std::vector<int> read_ids(io::ByteReader& in, Graph& graph) {
    for (std::size_t size = in.get_count(sizeof(std::uint32_t)); size > 0; --size)
      graph.places_.push_back({-1, -1, in.get<std::uint32_t>()});
    const std::size_t count_free = in.get_count(sizeof(std::int32_t));
    if (count_free > graph.places_.size()) fail<BadFile>("it has ", count_free, " free factor numbers of ", graph.places_.size());
    std::vector<int> numbers;
    std::vector<char> is_named(graph.places_.size(), 0);
    for (std::size_t i = 0; i < graph.places_.size(); ++i) {
      const auto number = in.get<std::int32_t>();
      if (number < 0 || static_cast<std::size_t>(number) >= is_named.size() || is_named[number] != 0)
        fail<BadFile>("factor number ", number, " is named twice, or is none of its ", is_named.size());
      is_named[number] = 1;
      numbers.push_back(number);
    }
    const auto end_of_free = numbers.begin() + static_cast<std::ptrdiff_t>(count_free);
    graph.free_.assign(numbers.rbegin(), std::make_reverse_iterator(end_of_free));
    return {numbers.begin(), end_of_free};
  }
  static void enter(Graph& graph, FactorBatch& batch, const Key* keys, double weight) {
    if (graph.free_.empty()) fail<BadFile>("it holds more factors than it names");
    graph.enter(batch, keys, weight);
  }
  static void read_batch(io::ByteReader& in, Graph& graph) {
    const std::string name = in.get_text();
    const auto bytes = in.get<std::uint64_t>();
    Loss loss;
    const auto kind = in.get<std::int32_t>();
    if (kind < 0 || kind > static_cast<int>(Loss::Kind::StudentT)) fail<BadFile>("it holds a loss of unknown kind ", kind);
    loss.kind = static_cast<Loss::Kind>(kind);
    loss.scale = in.get<double>();
    loss.per_component = in.get<bool>();
    loss.one_sided = in.get<bool>();
    std::size_t size = in.get_count(sizeof(double));
    if (name == "LinearPrior") {
      if (size > 1) fail<BadFile>("it holds a batch of ", size, " LinearPriors; one each");
      graph.batches_.push_back(std::make_unique<LinearPriorBatch>());
      if (size > 0) read_prior(in, graph);
      return;
    }
    const FactorType* type = io_type(name, bytes);
    graph.batches_.push_back(type->make(loss));
    FactorBatch& batch = *graph.batches_.back();
    loss.validate(batch.residual_dim());
    for (; size > 0; --size) {
      const auto weight = in.get<double>();
      std::vector<Key> keys;
      for (int k = 0; k < batch.arity(); ++k) keys.push_back(in.get_key());
      type->push(batch, in.take(bytes));
      enter(graph, batch, keys.data(), weight);
    }
  }
  static const FactorType* io_type(const std::string& name, std::uint64_t bytes) {
    const FactorType* type = find_factor_type(name);
    if (type == nullptr || type->bytes != bytes)
      fail<BadFile>("it holds factors of type ", name, " (", bytes, " bytes), which no code of this program adds");
    return type;
  }
  static void read_prior(io::ByteReader& in, Graph& graph) {
    const auto weight = in.get<double>();
    LinearPrior prior;
    for (std::size_t keys = in.get_count(sizeof(double)); keys > 0; --keys) {
      const Key key = in.get_key();
      const std::string name = in.get_text();
      const PoolBase& type = variable_type(name, in.get<std::int32_t>());
      prior.add_variable(key, type, ambient(in, type.ambient()).data());
    }
    if (prior.keys.empty()) fail<BadFile>("it holds a LinearPrior without variables");
    prior.rows = in.get<std::int32_t>();
    prior.constant = in.get<double>();
    if (prior.rows < 1) fail<BadFile>("it holds a LinearPrior without rows");
    in.require(sizeof(double) * static_cast<std::size_t>(prior.rows) * (prior.columns() + 1));
    prior.A = ambient(in, prior.rows * prior.columns());
    prior.b = ambient(in, prior.rows);
    prior.validate();
    FactorBatch& batch = *graph.batches_.back();
    static_cast<LinearPriorBatch&>(batch).hold(prior);
    enter(graph, batch, prior.keys.data(), weight);
  }
};

namespace io {

void write_binary(ByteWriter& out, const Graph& graph, const Values& values) {
  BinaryIo::write(out, values);
  BinaryIo::write(out, graph);
}

void read_binary(ByteReader& in, Graph& graph, Values& values) {
  BinaryIo::read(in, values);
  BinaryIo::read(in, graph);
}

}  // namespace io
}  // namespace holdfast
