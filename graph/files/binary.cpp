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

namespace {

/// Where a field of the file goes among this program's.
struct FieldPlace {
  std::size_t offset, bytes;
};

/// The layout of the bytes: each read mirrors its write.
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
      values.pool_of(type);
      for (std::size_t size = in.get_count(sizeof(std::uint64_t)); size > 0; --size) {
        const Key key = in.get_key();
        values.insert_ambient(key, type, ambient(in, type.ambient()).data());
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
    const Graph::Numbers numbers = graph.numbers();
    out.put<std::uint64_t>(numbers.generations.size());
    for (unsigned generation : numbers.generations) out.put<std::uint32_t>(generation);
    out.put<std::uint64_t>(numbers.free.size());
    for (int number : numbers.free) out.put<std::int32_t>(number);
    for (std::size_t b = 0; b < graph.batches().size(); ++b)
      for (int i = 0; i < graph.batches()[b]->size(); ++i) out.put<std::int32_t>(graph.id_of(static_cast<int>(b), i).number);
  }
  static const FactorType* saved_type(const FactorBatch& batch) {
    const FactorType* type = find_factor_type(batch.factor_type());
    if (type == nullptr) fail<BadFile>("a factor ", batch.name(), " cannot be saved: it was added by no code of this program");
    if (!type->is_saved)
      fail<BadFile>("a factor ", batch.name(), " cannot be saved: it does not list its members; give it fields() (graph/fields.hpp)",
                    " and a constructor without arguments, or remove it before saving");
    return type;
  }
  static std::size_t bytes_of(const std::vector<FieldType>& fields) {
    std::size_t bytes = 0;
    for (const FieldType& field : fields) bytes += field.bytes;
    return bytes;
  }
  static void write_fields(io::ByteWriter& out, const std::vector<FieldType>& fields) {
    out.put<std::uint64_t>(fields.size());
    for (const FieldType& field : fields) out.put(std::string_view(field.name)).put(std::string_view(field.type));
  }
  static void write(io::ByteWriter& out, const FactorBatch& batch) {
    const bool is_prior = batch.factor_type() == typeid(LinearPrior);
    const FactorType* type = is_prior ? nullptr : saved_type(batch);
    out.put(is_prior ? std::string_view("LinearPrior") : std::string_view(type->name));
    if (!is_prior) write_fields(out, type->fields);
    write_loss(out, batch, batch.family());
    out.put(batch.has_one_loss());
    out.put<std::uint64_t>(batch.size());
    std::vector<char> fields(is_prior ? 0 : bytes_of(type->fields));
    for (int i = 0; i < batch.size(); ++i) {
      out.put(batch.weight(i));
      if (!batch.has_one_loss()) write_loss(out, batch, batch.loss(i));
      if (is_prior) {
        write(out, static_cast<const LinearPriorBatch&>(batch).prior());
        continue;
      }
      for (int k = 0; k < batch.arity(); ++k) out.put(batch.keys(i)[k]);
      type->put(batch, i, fields.data());
      out.put(fields.data(), fields.size());
    }
  }
  static void write_loss(io::ByteWriter& out, const FactorBatch& batch, const Loss& loss) {
    if (!loss.is_named())
      fail<BadFile>("the loss ", loss.str(), " of ", batch.name(),
                    " cannot be written: files know losses by name; call register_loss<…>() first (graph/loss.hpp)");
    out.put(std::string_view(loss.str()));
  }
  static Loss read_loss(io::ByteReader& in) {
    const std::string text = in.get_text();
    try {
      return Loss::parse(text);
    } catch (const BadOption& error) {
      fail<BadFile>("it holds a loss this program does not know: ", error.what());
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
    std::size_t named = read_ids(in, graph);
    for (std::size_t batches = in.get_count(1); batches > 0; --batches) read_batch(in, graph, named);
    if (named != 0) fail<BadFile>("it names ", named, " factors more than it holds");
  }
  // The graph hands them out again: first those of its factors in the batches' order, then those that stay free. Returns how many factors.
  static std::size_t read_ids(io::ByteReader& in, Graph& graph) {
    Graph::Numbers numbers;
    for (std::size_t size = in.get_count(sizeof(std::uint32_t)); size > 0; --size) numbers.generations.push_back(in.get<std::uint32_t>());
    const std::size_t count_free = in.get_count(sizeof(std::int32_t));
    if (count_free > numbers.generations.size())
      fail<BadFile>("it has ", count_free, " free factor numbers of ", numbers.generations.size());
    for (std::size_t i = 0; i < numbers.generations.size(); ++i) numbers.free.push_back(in.get<std::int32_t>());
    std::reverse(numbers.free.begin() + static_cast<std::ptrdiff_t>(count_free), numbers.free.end());
    graph.set_numbers(numbers);
    return numbers.free.size() - count_free;
  }
  static void enter(Graph& graph, FactorBatch& batch, const Key* keys, double weight, const Loss& loss, std::size_t& named) {
    if (named-- == 0) fail<BadFile>("it holds more factors than it names");
    if (!(std::isfinite(weight) && weight >= 0))
      fail<BadFile>("a factor ", batch.name(), " has the weight ", weight, "; it must be finite and >= 0");
    graph.enter(batch, keys, weight, loss);
  }
  static void read_batch(io::ByteReader& in, Graph& graph, std::size_t& named) {
    const std::string name = in.get_text();
    const bool is_prior = name == "LinearPrior";
    const FactorType* type = is_prior ? nullptr : known_type(name);
    const std::vector<FieldPlace> places = is_prior ? std::vector<FieldPlace>() : read_fields(in, *type);
    const Loss loss = read_loss(in);
    const bool has_one_loss = in.get_bool();
    std::size_t size = in.get_count(sizeof(double));
    if (is_prior) {
      if (size > 1) fail<BadFile>("it holds a batch of ", size, " LinearPriors; one each");
      FactorBatch& batch = graph.add_batch(std::make_unique<LinearPriorBatch>());
      if (size > 0) read_prior(in, graph, static_cast<LinearPriorBatch&>(batch), named);
      return;
    }
    FactorBatch& batch = graph.add_batch(type->make(loss));
    loss.validate(batch.residual_dim());
    std::vector<char> fields(bytes_of(type->fields));
    for (; size > 0; --size) {
      const auto weight = in.get<double>();
      const Loss own = has_one_loss ? loss : read_loss(in);
      own.validate(batch.residual_dim());
      if (!own.is_of_family(loss)) fail<BadFile>("it holds the loss ", own.str(), " in a batch of ", loss.str());
      std::vector<Key> keys;
      for (int k = 0; k < batch.arity(); ++k) keys.push_back(in.get_key());
      for (const FieldPlace& place : places) std::memcpy(fields.data() + place.offset, in.take(place.bytes), place.bytes);
      type->push(batch, fields.data());
      enter(graph, batch, keys.data(), weight, own, named);
    }
  }
  static const FactorType* known_type(const std::string& name) {
    const FactorType* type = find_factor_type(name);
    if (type == nullptr || !type->is_saved) fail<BadFile>("it holds factors of type ", name, ", which no code of this program adds");
    return type;
  }
  // Every field of the file has its place, and every place its field.
  static std::vector<FieldPlace> read_fields(io::ByteReader& in, const FactorType& type) {
    std::vector<FieldPlace> places;
    std::vector<bool> found(type.fields.size(), false);
    for (std::size_t count = in.get_count(1); count > 0; --count) {
      const std::string name = in.get_text(), as = in.get_text();
      std::size_t k = 0, offset = 0;
      while (k < type.fields.size() && type.fields[k].name != name) offset += type.fields[k++].bytes;
      if (k == type.fields.size()) fail<BadFile>("its factors ", type.name, " have a field ", name, " (", as, ") that they have not here");
      if (found[k]) fail<BadFile>("its factors ", type.name, " have the field ", name, " twice");
      if (type.fields[k].type != as)
        fail<BadFile>("the field ", name, " of its factors ", type.name, " is of type ", as, ", here ", type.fields[k].type);
      found[k] = true;
      places.push_back({offset, type.fields[k].bytes});
    }
    for (std::size_t k = 0; k < found.size(); ++k)
      if (!found[k])
        fail<BadFile>("its factors ", type.name, " have no field ", type.fields[k].name, " (", type.fields[k].type,
                      "), which they have here");
    return places;
  }
  static void read_prior(io::ByteReader& in, Graph& graph, LinearPriorBatch& batch, std::size_t& named) {
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
    batch.hold(prior);
    enter(graph, batch, prior.keys.data(), weight, Squared{}, named);
  }
};

}  // namespace

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
