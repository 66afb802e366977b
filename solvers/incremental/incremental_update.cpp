// Updates: what is new enters, variables that moved are linearised anew, and where that does not settle, irls solves the whole graph.
#include <algorithm>
#include <cmath>
#include <holdfast/graph/detail/evaluation_error.hpp>
#include <holdfast/solvers/detail/clock.hpp>
#include <holdfast/solvers/incremental/internal/incremental_state.hpp>
#include <holdfast/solvers/irls/irls.hpp>

namespace holdfast {
namespace {

constexpr double kFullAccuracy = 1e-7;

/// What a function factor threw, to be appended; "" for the others.
std::string said_by(const FactorBatch& batch) {
  const std::string error = detail::take_error(batch);
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
  if (options_.findings || options_.report) describe();
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
    if (s.key_of.size() <= static_cast<std::size_t>(variable.number)) s.key_of.resize(variable.number + 1);
    s.key_of[variable.number] = key;
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
  if (options_.findings || options_.report) s.looked_at.push_back(id);
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
    if (s.tree.moved(number) > options_.relinearize * options_.relinearize)
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
  if (s.tree.is_empty()) {  // irls would say that there is nothing to solve for
    Summary summary;
    summary.cost = summary.cost_first = cost();
    summary.termination = Termination::converged;
    summary.rule = "no variable is free";
    return summary;
  }
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
