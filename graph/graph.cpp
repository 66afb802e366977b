#include <algorithm>
#include <holdfast/graph/graph.hpp>
#include <holdfast/graph/resolved.hpp>

namespace holdfast {
namespace {

std::string described(const std::string& name, const Key* keys, std::size_t count) {
  std::string text = name + "(";
  for (std::size_t i = 0; i < count; ++i) text += (i ? ", " : "") + keys[i].str();
  return text + ")";
}

}  // namespace

Graph::Graph() : structure_(new_structure_stamp()) {}

Graph::Graph(const Graph& other) : places_(other.places_), free_(other.free_), fixed_(other.fixed_), structure_(other.structure_) {
  for (const auto& batch : other.batches_) batches_.push_back(batch->clone());
}

Graph& Graph::operator=(const Graph& other) {
  if (this != &other) *this = Graph(other);
  return *this;
}

// What is left behind is empty, and has another structure than what was taken.
Graph::Graph(Graph&& other) noexcept : Graph() { *this = std::move(other); }

Graph& Graph::operator=(Graph&& other) noexcept {
  if (this == &other) return *this;
  batches_ = std::exchange(other.batches_, {});
  places_ = std::exchange(other.places_, {});
  free_ = std::exchange(other.free_, {});
  fixed_ = std::exchange(other.fixed_, {});
  structure_ = std::exchange(other.structure_, new_structure_stamp());
  return *this;
}

void Graph::check_new(std::string (*name)(), const Key* keys, std::size_t count, const Loss& loss, int residual_dim, double weight) const {
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (keys[i] == keys[j])
        fail<BadKey>(described(name(), keys, count), ": key ", keys[i], " occurs twice; a factor ties different variables");
  if (!(std::isfinite(weight) && weight >= 0))
    fail<BadNumber>(described(name(), keys, count), ": weight = ", weight, " must be finite and >= 0; to leave a factor out, remove it");
  loss.validate(residual_dim);
}

void Graph::rethrow_named(const std::string& name, const Key* keys, std::size_t count, const BadNumber& error) const {
  fail<BadNumber>(described(name, keys, count), ": ", error.what());
}

// The factor itself is in the batch already.
FactorId Graph::enter(FactorBatch& batch, const Key* keys, double weight, const Loss& loss) {
  const auto it = std::find_if(batches_.begin(), batches_.end(), [&](const auto& b) { return b.get() == &batch; });
  int number = static_cast<int>(places_.size());
  if (free_.empty()) {
    places_.emplace_back();
  } else {
    number = free_.back();
    free_.pop_back();
  }
  batch.push_entries(keys, weight, loss, number);
  Place& place = places_[number];
  place.batch = static_cast<int>(it - batches_.begin());
  place.index = batch.size() - 1;
  structure_ = new_structure_stamp();
  return {number, place.generation};
}

FactorBatch* Graph::find_batch(std::type_index factor_type, const Loss& loss) {
  for (auto& batch : batches_)
    if (batch->factor_type() == factor_type && batch->family().is_of_family(loss)) return batch.get();
  return nullptr;
}

FactorBatch& Graph::add_batch(std::unique_ptr<FactorBatch> batch) {
  batches_.push_back(std::move(batch));
  return *batches_.back();
}

Graph::Numbers Graph::numbers() const {
  Numbers numbers;
  for (const Place& place : places_) numbers.generations.push_back(place.generation);
  numbers.free = free_;
  return numbers;
}

void Graph::set_numbers(const Numbers& numbers) {
  const std::size_t count = numbers.generations.size();
  if (size() != 0 || numbers.free.size() != count)
    fail<BadKey>("a graph of ", size(), " factors takes no ", count, " numbers of which ", numbers.free.size(), " are free; all must be");
  std::vector<bool> named(count, false);
  for (int number : numbers.free) {
    if (number < 0 || static_cast<std::size_t>(number) >= count || named[number])
      fail<BadKey>("factor number ", number, " is named twice, or is none of its ", count);
    named[number] = true;
  }
  places_.clear();
  for (unsigned generation : numbers.generations) places_.push_back({-1, -1, generation});
  free_ = numbers.free;
}

FactorId Graph::add(const LinearPrior& prior) {
  check_new([] { return std::string("LinearPrior"); }, prior.keys.data(), prior.keys.size(), Loss{}, prior.rows, 1.0);
  try {
    prior.validate();
  } catch (const BadNumber& error) {
    rethrow_named(LinearPrior::name(), prior.keys.data(), prior.keys.size(), error);
  }
  auto it = std::find_if(batches_.begin(), batches_.end(),
                         [](const auto& b) { return b->factor_type() == typeid(LinearPrior) && b->size() == 0; });
  if (it == batches_.end()) it = batches_.insert(it, std::make_unique<LinearPriorBatch>());
  static_cast<LinearPriorBatch&>(**it).hold(prior);
  return enter(**it, prior.keys.data(), 1.0, Squared{});
}

std::vector<FactorId> Graph::add(const std::shared_ptr<const FunctionFactors>& function, const std::vector<Key>& keys, const Loss& loss) {
  function->validate();
  const std::size_t arity = function->types.size();
  if (keys.size() % arity != 0)
    fail<BadKey>(function->name, ": ", keys.size(), " keys are no multiple of the ", arity, " variables of a factor");
  for (std::size_t i = 0; i < keys.size(); i += arity)
    check_new([] { return std::string("Function"); }, &keys[i], arity, loss, function->residual_dim, 1.0);
  auto it = std::find_if(batches_.begin(), batches_.end(), [&](const auto& one) {
    const auto* functions = dynamic_cast<const FunctionBatch*>(one.get());
    return functions != nullptr && functions->function() == function && one->family().is_of_family(loss);
  });
  if (it == batches_.end()) it = batches_.insert(it, std::make_unique<FunctionBatch>(function, loss));
  std::vector<FactorId> ids;
  for (std::size_t i = 0; i < keys.size(); i += arity) {
    static_cast<FunctionBatch&>(**it).push(function->given++);
    ids.push_back(enter(**it, &keys[i], 1.0, loss));
  }
  return ids;
}

FactorId Graph::add_from(const Graph& other, FactorId id) {
  const Place from = other.checked(id);
  const FactorBatch& batch = *other.batches_[from.batch];
  if (batch.factor_type() == typeid(LinearPrior)) return add(static_cast<const LinearPriorBatch&>(batch).prior());
  const Loss& loss = batch.loss(from.index);
  auto to = std::find_if(batches_.begin(), batches_.end(),
                         [&](const auto& one) { return one->takes_factors_of(batch) && one->family().is_of_family(loss); });
  if (to == batches_.end()) to = batches_.insert(to, batch.make_empty(loss));
  (*to)->push_from(batch, from.index);
  return enter(**to, batch.keys(from.index), batch.weight(from.index), loss);
}

bool Graph::contains(FactorId id) const {
  return id.number >= 0 && id.number < static_cast<int>(places_.size()) && places_[id.number].batch >= 0 &&
         places_[id.number].generation == id.generation;
}

const Graph::Place& Graph::checked(FactorId id) const {
  if (!contains(id)) fail<BadKey>("factor #", id.number, " is not in the graph (any more); keep the id that add() returned until remove()");
  return places_[id.number];
}

FactorId Graph::id_of(int batch, int index) const {
  require_batch(batch);
  if (index < 0 || index >= batches_[batch]->size())
    fail<BadKey>("factor ", index, " of batch ", batch, ": the batch holds ", batches_[batch]->size(), "; ask batches()[", batch,
                 "]->size()");
  const int number = batches_[batch]->ids_[index];
  return {number, places_[number].generation};
}

void Graph::remove(FactorId id) {
  const Place gone = checked(id);
  take_out(gone);
  places_[id.number] = {-1, -1, gone.generation + 1};
  free_.push_back(id.number);
  structure_ = new_structure_stamp();
}

void Graph::take_out(const Place& place) {
  FactorBatch& batch = *batches_[place.batch];
  batch.erase(place.index);
  places_[batch.ids_.back()].index = place.index;
  batch.erase_entries(place.index);
}

void Graph::set_weight(FactorId id, double weight) {
  const Place& place = checked(id);
  if (!(std::isfinite(weight) && weight >= 0))
    fail<BadNumber>(batches_[place.batch]->describe(place.index), ": weight = ", weight,
                    " must be finite and >= 0; to leave a factor out, remove it");
  batches_[place.batch]->weights_[place.index] = weight;
}

void Graph::require_batch(int batch) const {
  if (batch < 0 || batch >= static_cast<int>(batches_.size()))
    fail<BadKey>("batch ", batch, " is not in the graph: it has ", batches_.size(), "; ask batches() or place(id)");
}

void Graph::validate_loss(const FactorBatch& batch, const Loss& loss) const {
  loss.validate(batch.residual_dim());
  if (batch.factor_type() == typeid(LinearPrior) && loss.kind != Loss::Kind::Squared)
    fail<BadOption>("LinearPrior: its loss is squared, since its terms were weighed when it was made; ", loss.str(),
                    " cannot be laid on them");
}

void Graph::set_loss(int batch, const Loss& loss) {
  require_batch(batch);
  validate_loss(*batches_[batch], loss);
  batches_[batch]->losses_.assign(1, loss);
}

void Graph::set_loss(FactorId id, const Loss& loss) {
  const Place from = checked(id);
  FactorBatch& batch = *batches_[from.batch];
  validate_loss(batch, loss);
  if (batch.family().is_of_family(loss) || batch.size() == 1) return batch.set_loss_of(from.index, loss);
  auto to = std::find_if(batches_.begin(), batches_.end(),
                         [&](const auto& other) { return other->takes_factors_of(batch) && other->family().is_of_family(loss); });
  if (to == batches_.end()) to = batches_.insert(to, batch.make_empty(loss));
  (*to)->push_from(batch, from.index);
  (*to)->push_entries(batch.keys(from.index), batch.weight(from.index), loss, id.number);
  take_out(from);
  places_[id.number].batch = static_cast<int>(to - batches_.begin());
  places_[id.number].index = (*to)->size() - 1;
  structure_ = new_structure_stamp();
}

void Graph::fix(Key key) {
  if (fixed_.insert(key).second) structure_ = new_structure_stamp();
}

void Graph::unfix(Key key) {
  if (fixed_.erase(key) != 0) structure_ = new_structure_stamp();
}

Graph Graph::relaxed() const {
  Graph convex;
  convex.places_ = places_;
  convex.free_ = free_;
  convex.fixed_ = fixed_;
  for (const auto& batch : batches_) {
    auto counterpart = batch->relaxed_factors();
    const bool is_other = counterpart != nullptr;
    if (is_other) counterpart->take_place_of(*batch);
    convex.batches_.push_back(is_other ? std::move(counterpart) : batch->clone());
    for (Loss& loss : convex.batches_.back()->losses_) {
      loss = loss.relaxed();
      if (is_other && loss.one_sided) loss = Squared{};  // robust where a range is too long, which a ball does not see
      if (is_other) loss.per_component = false;          // its components are others
    }
  }
  return convex;
}

Eigen::VectorXd Graph::residual(FactorId id, const Values& values) const {
  const Place& place = checked(id);
  const FactorBatch& batch = *batches_[place.batch];
  std::vector<const double*> x;
  for (int k = 0; k < batch.arity(); ++k) {
    const Key key = batch.keys(place.index)[k];
    const Values::Slot& slot = values.slot(key);
    const PoolBase& pool = values.pool(slot.pool);
    if (pool.type() != batch.types()[k])
      fail<BadType>("factor ", batch.describe(place.index), ": key ", key, " is a ", pool.type_name(),
                    " in the values, but the factor needs a ", batch.type_names()[k], "; insert it as one");
    x.push_back(pool.data(slot.index));
  }
  Eigen::VectorXd r(batch.residual_dim());
  batch.evaluate_at(place.index, x.data(), r.data(), nullptr);
  return r;
}

std::vector<FactorId> Graph::factors_on(Key key) const {
  std::vector<FactorId> ids;
  for (std::size_t b = 0; b < batches_.size(); ++b)
    for (int i = 0; i < batches_[b]->size(); ++i) {
      const Key* keys = batches_[b]->keys(i);
      if (std::find(keys, keys + batches_[b]->arity(), key) != keys + batches_[b]->arity()) ids.push_back(id_of(static_cast<int>(b), i));
    }
  return ids;
}

double Graph::cost(const Values& values) const { return Resolved(*this, values).cost(*this, values); }

}  // namespace holdfast
