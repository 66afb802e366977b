#include <algorithm>
#include <cmath>
#include <holdfast/graph/resolved.hpp>
#include <holdfast/solvers/detail/clock.hpp>
#include <holdfast/solvers/incremental/incremental.hpp>
#include <holdfast/solvers/incremental/internal/clique_tree.hpp>
#include <holdfast/solvers/irls/irls.hpp>
#include <holdfast/solvers/window/marginalize.hpp>
#include <unordered_map>
#include <unordered_set>

namespace holdfast {

/// What ties the graph and the values to the tree.
struct Incremental::State {
  struct Variable {
    int number = -1;  ///< in the tree; −1: fixed
    Values::Slot slot{-1, -1};
    int dim = 0;
  };
  detail::CliqueTree tree;
  std::unordered_map<Key, Variable> variables;
  std::vector<int> dim_of;              ///< by number in the tree
  std::vector<Key> key_of;              ///< by number in the tree
  std::vector<int> term_of;             ///< by FactorId::number; −1: none
  std::vector<FactorId> factor_of;      ///< by term
  std::vector<std::vector<int>> index;  ///< by batch: the pool index of each variable of each factor
  std::vector<FactorId> new_factors;
  double work = 0, whole = 0;   ///< multiply–add pairs since all was ordered afresh, and of that
  std::unordered_set<int> far;  ///< variables of the tree that may be further than `relinearize` from where they stand
  std::vector<double> contribution, H, g;
  std::vector<char> is_free;
  std::vector<int> numbers;

  Variable& of(Key key) {
    const auto it = variables.find(key);
    if (it == variables.end()) fail<BadKey>("there is no variable ", key, "; insert() it first");
    return it->second;
  }
};

namespace {

constexpr double kFullAccuracy = 1e-7;

/// What a function factor threw, to be appended; "" for the others.
std::string said_by(const FactorBatch& batch) {
  const std::string error = batch.take_error();
  return error.empty() ? error : ": " + error;
}

/// The parts of a factor's contribution (FactorBatch::contributions) that belong to variables of the tree, as one matrix.
void unpack(const FactorBatch& batch, const std::vector<char>& is_free, const double* from, std::vector<double>& H,
            std::vector<double>& g) {
  const std::vector<int>& dims = batch.dims();
  const int arity = batch.arity();
  constexpr int kFew = 8;
  int few[kFew];
  std::vector<int> many;
  if (arity > kFew) many.resize(arity);
  int* const at = arity > kFew ? many.data() : few;
  std::fill_n(at, arity, -1);
  int n = 0;
  for (int k = 0; k < arity; ++k)
    if (is_free[k]) at[k] = n, n += dims[k];
  H.assign(static_cast<std::size_t>(n) * n, 0);
  g.assign(n, 0);
  for (int b = 0; b < arity; ++b)
    for (int a = b; a < arity; ++a, from += dims[a - 1] * dims[b]) {
      if (at[a] < 0 || at[b] < 0) continue;
      const double* value = from;
      for (int c = 0; c < dims[b]; ++c)
        for (int r = 0; r < dims[a]; ++r, ++value)
          H[static_cast<std::size_t>(at[b] + c) * n + at[a] + r] = H[static_cast<std::size_t>(at[a] + r) * n + at[b] + c] = *value;
    }
  for (int k = 0; k < arity; from += dims[k++])
    if (at[k] >= 0) std::copy_n(from, dims[k], g.begin() + at[k]);
}

}  // namespace

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
  const std::size_t arity = static_cast<std::size_t>(graph_.batches()[place.batch]->arity());
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

// ---- updates

const IncrementalStep& Incremental::update() {
  const Stopwatch watch;
  step_ = {};
  enter_variables();
  enter_factors();
  State& s = *state_;
  solve(s.whole > 0 && s.work > options_.reorder * s.whole);
  while (!s.far.empty() && step_.steps < options_.most_steps) relinearize();
  if (!s.far.empty()) step_.batch = solve_batch(options_.relinearize).usable();
  step_.settled = s.far.empty();
  step_.seconds = watch.seconds();
  return step_;
}

void Incremental::enter_variables() {
  State& s = *state_;
  for (const Key key : new_keys_) {
    State::Variable& variable = s.variables[key];
    variable.slot = start_.slot(key);
    variable.dim = start_.pool(variable.slot.pool).dim();
    if (graph_.is_fixed(key)) continue;
    variable.number = s.tree.add_variable(variable.dim);
    if (s.key_of.size() <= static_cast<std::size_t>(variable.number)) {
      s.key_of.resize(variable.number + 1);
      s.dim_of.resize(variable.number + 1);
    }
    s.key_of[variable.number] = key;
    s.dim_of[variable.number] = variable.dim;
  }
  new_keys_.clear();
}

void Incremental::enter_factors() {
  State& s = *state_;
  while (!s.new_factors.empty()) {  // one after the other: where one throws, those before it are in
    const FactorId id = s.new_factors.back();
    linearize(id, nullptr);
    s.new_factors.pop_back();
    if (s.term_of.size() <= static_cast<std::size_t>(id.number)) s.term_of.resize(id.number + 1, -1);
    s.term_of[id.number] = -1;
    if (s.numbers.empty()) continue;  // all fixed
    const int term = s.tree.add_term(s.numbers, s.H, s.g);
    s.term_of[id.number] = term;
    if (s.factor_of.size() <= static_cast<std::size_t>(term)) s.factor_of.resize(term + 1);
    s.factor_of[term] = id;
  }
}

/// H and g of a factor where its variables were linearised, and their numbers; known: those, where it has a term already.
void Incremental::linearize(FactorId id, const std::vector<int>* known) {
  State& s = *state_;
  const Graph::Place& place = graph_.place(id);
  const FactorBatch& batch = *graph_.batches()[place.batch];
  s.contribution.resize(batch.stride());
  batch.contributions(start_, s.index[place.batch].data(), place.index, place.index + 1, Curvature::irls, s.contribution.data());
  if (!std::all_of(s.contribution.begin(), s.contribution.end(), [](double x) { return std::isfinite(x); }))
    fail<BadNumber>(batch.describe(place.index), ": its residual or Jacobian is not finite; remove() it, or check its measurement",
                    said_by(batch));
  s.is_free.assign(batch.arity(), 1);
  if (known == nullptr || static_cast<int>(known->size()) < batch.arity()) {
    s.numbers.clear();
    for (int k = 0; k < batch.arity(); ++k) {
      const int number = s.of(batch.keys(place.index)[k]).number;
      s.is_free[k] = number >= 0;
      if (number >= 0) s.numbers.push_back(number);
    }
  }
  unpack(batch, s.is_free, s.contribution.data(), s.H, s.g);
}

void Incremental::solve(bool afresh) {
  State& s = *state_;
  const int culprit = afresh ? s.tree.reorder(options_.propagate) : s.tree.update(options_.propagate);
  if (culprit >= 0)
    fail<Underdetermined>("the graph leaves variable ", s.key_of[culprit],
                          " or one tied to it free; add a prior or a measurement and update again");
  ++step_.steps;
  step_.eliminated += s.tree.remade();
  step_.reordered = step_.reordered || afresh;
  s.work = afresh ? 0 : s.work + s.tree.work();
  s.whole = afresh ? s.tree.work() : std::max(s.whole, s.tree.work());
  for (const int number : s.tree.changed()) {
    const double* delta = s.tree.delta(number);
    if (std::any_of(delta, delta + s.dim_of[number], [&](double d) { return std::abs(d) > options_.relinearize; }))
      s.far.insert(number);
    else
      s.far.erase(number);
  }
}

/// A Gauss–Newton step from where the far variables are now.
void Incremental::relinearize() {
  State& s = *state_;
  std::vector<int> touched;
  for (const int number : s.far) {
    const State::Variable& variable = s.of(s.key_of[number]);
    PoolBase& pool = start_.pool(variable.slot.pool);
    pool.retract(variable.slot.index, pool, s.tree.delta(number));
    s.tree.restart(number);
    const std::vector<int>& terms = s.tree.terms_on(number);
    touched.insert(touched.end(), terms.begin(), terms.end());
    ++step_.relinearized;
  }
  s.far.clear();
  std::sort(touched.begin(), touched.end());
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  for (const int term : touched) {
    linearize(s.factor_of[term], &s.tree.variables_of(term));
    s.tree.change_term(term, s.H, s.g);
  }
  solve(false);
}

/// irls on the whole graph, from the better one of the estimate and where it was linearised, and the tree made again where that ends.
Summary Incremental::solve_batch(double accuracy) {
  State& s = *state_;
  Values estimate = values();
  const double here = graph_.cost(estimate), there = graph_.cost(start_);
  if (!(here <= there)) estimate.assign(start_);
  Options options;
  options.cost_tolerance = std::min(1e-9, accuracy * accuracy);
  const Summary summary = Irls(options).solve(graph_, estimate);
  if (!summary.usable()) return summary;
  start_.assign(estimate);
  for (auto& [key, variable] : s.variables)
    if (variable.number >= 0) s.tree.restart(variable.number);
  s.far.clear();
  for (std::size_t b = 0; b < graph_.batches().size(); ++b)
    for (int i = 0; i < graph_.batches()[b]->size(); ++i) {
      const FactorId id = graph_.id_of(static_cast<int>(b), i);
      const int term = s.term_of[id.number];
      if (term < 0) continue;
      linearize(id, &s.tree.variables_of(term));
      s.tree.change_term(term, s.H, s.g);
    }
  solve(true);
  return summary;
}

Summary Incremental::finish() {
  update();
  return solve_batch(kFullAccuracy);
}

}  // namespace holdfast
