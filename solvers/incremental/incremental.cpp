#include <algorithm>
#include <holdfast/solvers/incremental/internal/incremental_state.hpp>
#include <holdfast/solvers/window/marginalize.hpp>

namespace holdfast {

void IncrementalOptions::validate() const {
  if (!(relinearize > 0)) fail<BadOption>("IncrementalOptions.relinearize = ", relinearize, ", must be > 0");
  if (!(propagate >= 0)) fail<BadOption>("IncrementalOptions.propagate = ", propagate, ", must be >= 0");
  if (most_steps < 1) fail<BadOption>("IncrementalOptions.most_steps = ", most_steps, ", must be >= 1");
  if (!(reorder > 0)) fail<BadOption>("IncrementalOptions.reorder = ", reorder, ", must be > 0");
}

Incremental::Incremental(IncrementalOptions options) : options_(options), state_(std::make_unique<State>()) { options_.validate(); }
Incremental::~Incremental() = default;
Incremental::Incremental(Incremental&&) noexcept = default;
Incremental& Incremental::operator=(Incremental&&) noexcept = default;

// ---- the graph

FactorId Incremental::add(const LinearPrior& prior) { return entered(graph_.add(prior)); }

void Incremental::insert_from(const Values& values, Key key) {
  const Values::Slot& slot = values.slot(key);
  const PoolBase& pool = values.pool(slot.pool);
  start_.insert_ambient(key, pool.kind(), pool.data(slot.index));
  new_keys_.push_back(key);
}

/// A factor that has been put at the end of its batch.
FactorId Incremental::entered(FactorId id) {
  State& s = *state_;
  const Graph::Place& place = graph_.place(id);
  const FactorBatch& batch = *graph_.batches()[place.batch];
  std::vector<int> slots;
  try {
    for (int k = 0; k < batch.arity(); ++k) {
      const Key key = batch.keys(place.index)[k];
      const Values::Slot& slot = start_.slot(key);
      if (start_.pool(slot.pool).type() != batch.types()[k])
        fail<BadType>(batch.describe(place.index), ": key ", key, " is a ", start_.pool(slot.pool).type_name(), ", the factor needs a ",
                      batch.type_names()[k]);
      slots.push_back(slot.index);
    }
  } catch (...) {
    graph_.remove(id);
    throw;
  }
  s.index.resize(graph_.batches().size());
  s.index[place.batch].insert(s.index[place.batch].end(), slots.begin(), slots.end());
  s.new_factors.push_back(id);
  return id;
}

void Incremental::remove(FactorId id) {
  State& s = *state_;
  const Graph::Place place = graph_.place(id);
  const FactorBatch& batch = *graph_.batches()[place.batch];
  const std::size_t arity = static_cast<std::size_t>(batch.arity());
  if (options_.findings) s.touched.insert(batch.keys(place.index), batch.keys(place.index) + arity);
  std::vector<int>& index = s.index[place.batch];
  std::copy(index.end() - static_cast<std::ptrdiff_t>(arity), index.end(),
            index.begin() + static_cast<std::ptrdiff_t>(arity) * place.index);  // the last one takes its place, as in the batch
  index.resize(index.size() - arity);
  graph_.remove(id);
  const auto same = [&](FactorId other) { return other.number == id.number && other.generation == id.generation; };
  const auto noted = std::find_if(s.new_factors.begin(), s.new_factors.end(), same);
  if (noted != s.new_factors.end()) {
    s.new_factors.erase(noted);
    return;
  }
  int& term = s.term_of[id.number];
  if (term >= 0) s.tree.remove_term(term);
  term = -1;
}

void Incremental::fix(Key key) {
  start_.slot(key);
  if (const auto it = state_->variables.find(key); it != state_->variables.end() && it->second.number >= 0)
    fail<BadKey>("variable ", key, " has been estimated already; fix() comes before its first update()");
  graph_.fix(key);
}

void Incremental::erase(Key key) {
  State& s = *state_;
  start_.slot(key);
  for (const FactorId id : graph_.factors_on(key)) remove(id);
  if (const auto it = s.variables.find(key); it != s.variables.end()) {
    if (it->second.number >= 0) {
      s.far.erase(it->second.number);
      s.tree.remove_variable(it->second.number);
    }
    s.variables.erase(it);
  }
  new_keys_.erase(std::remove(new_keys_.begin(), new_keys_.end(), key), new_keys_.end());
  graph_.unfix(key);
  // The last of its pool takes its place.
  const Values::Slot slot = start_.slot(key);
  const Key moved = start_.pool(slot.pool).keys().back();
  start_.erase(key);
  if (moved == key) return;
  if (const auto it = s.variables.find(moved); it != s.variables.end()) it->second.slot = slot;
  for (const FactorId id : graph_.factors_on(moved)) {
    const Graph::Place& place = graph_.place(id);
    const FactorBatch& batch = *graph_.batches()[place.batch];
    for (int k = 0; k < batch.arity(); ++k)
      if (batch.keys(place.index)[k] == moved) s.index[place.batch][static_cast<std::size_t>(place.index) * batch.arity() + k] = slot.index;
  }
}

void Incremental::marginalize(const std::vector<Key>& keys) {
  for (const Key key : keys) {
    start_.slot(key);
    // The prior is made on a graph of the variable's factors alone, linearised where the estimate is.
    Graph part;
    Values estimate;
    for (const FactorId id : graph_.factors_on(key)) {
      const Graph::Place& place = graph_.place(id);
      const FactorBatch& batch = *graph_.batches()[place.batch];
      for (int k = 0; k < batch.arity(); ++k) insert_estimate(batch.keys(place.index)[k], part, estimate);
      part.add_from(graph_, id);
    }
    if (part.size() == 0) {
      erase(key);
      continue;
    }
    Marginalizer marginalizer;
    const FactorId prior = marginalizer.eliminate(part, estimate, key);
    std::optional<LinearPrior> left;
    if (prior.number >= 0) left = std::as_const(part).at<LinearPrior>(prior);
    erase(key);
    if (left) add(*left);
  }
}

/// Of one variable, into values that hold few.
void Incremental::insert_estimate(Key key, Graph& part, Values& estimate) const {
  if (estimate.contains(key)) return;
  const Values::Slot& slot = start_.slot(key);
  const PoolBase& pool = start_.pool(slot.pool);
  std::vector<double> x(pool.data(slot.index), pool.data(slot.index) + pool.ambient());
  if (const double* delta = delta_of(key)) pool.retract_ambient(pool.data(slot.index), delta, x.data());
  estimate.insert_ambient(key, pool.kind(), x.data());
  if (graph_.is_fixed(key)) part.fix(key);
}

// ---- the estimate

std::size_t Incremental::size() const { return start_.size(); }

const double* Incremental::delta_of(Key key) const {
  const auto it = state_->variables.find(key);
  return it == state_->variables.end() || it->second.number < 0 ? nullptr : state_->tree.delta(it->second.number);
}

Values Incremental::values() const {
  Values all = start_;
  for (const auto& [key, variable] : state_->variables)
    if (variable.number >= 0)
      all.pool(variable.slot.pool).retract(variable.slot.index, start_.pool(variable.slot.pool), state_->tree.delta(variable.number));
  return all;
}

void Incremental::read_into(Values& values) const {
  for (const auto& from : start_.pools())
    for (int i = 0; i < from->size(); ++i) {
      const Key key = from->keys()[static_cast<std::size_t>(i)];
      const Values::Slot& slot = values.slot(key);
      double* const x = values.pool(slot.pool).data(slot.index);
      if (const double* delta = delta_of(key))
        from->retract_ambient(from->data(i), delta, x);
      else
        std::copy_n(from->data(i), from->ambient(), x);
    }
}

double Incremental::cost() const { return graph_.cost(values()); }

Eigen::MatrixXd Incremental::covariance(const std::vector<Key>& keys) {
  std::vector<int> numbers;
  for (const Key key : keys) {
    const State::Variable& variable = state_->of(key);
    if (variable.number < 0) fail<BadKey>("variable ", key, " is fixed: it has no covariance");
    numbers.push_back(variable.number);
  }
  return state_->tree.covariance(numbers);
}

}  // namespace holdfast
