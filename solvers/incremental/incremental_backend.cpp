#include <algorithm>
#include <cmath>
#include <cstring>
#include <holdfast/graph/gradient.hpp>
#include <holdfast/solvers/detail/clock.hpp>
#include <holdfast/solvers/incremental/incremental_backend.hpp>
#include <holdfast/solvers/internal/minimizer.hpp>

namespace holdfast {
namespace {

/// The variables of `values` that `last` has, too, are where that has them, and there are some.
bool begins_at(const Values& last, const Values& values) {
  bool any = false;
  for (std::size_t p = 0; p < values.pools().size(); ++p) {
    const PoolBase& pool = values.pool(static_cast<int>(p));
    const PoolBase* same =
        p < last.pools().size() && last.pool(static_cast<int>(p)).type() == pool.type() ? &last.pool(static_cast<int>(p)) : nullptr;
    for (int i = 0; i < pool.size(); ++i) {
      const Key key = pool.keys()[i];
      const double* before;
      if (same != nullptr && i < same->size() && same->keys()[i] == key) {
        before = same->data(i);
      } else {
        if (!last.contains(key)) continue;
        const Values::Slot& slot = last.slot(key);
        if (last.pool(slot.pool).type() != pool.type()) return false;
        before = last.pool(slot.pool).data(slot.index);
      }
      if (std::memcmp(before, pool.data(i), sizeof(double) * static_cast<std::size_t>(pool.ambient())) != 0) return false;
      any = true;
    }
  }
  return any;
}

}  // namespace

IncrementalBackend::IncrementalBackend(Options chosen, IncrementalOptions how) : Backend(std::move(chosen)), how_(how) { how_.validate(); }

void IncrementalBackend::forget() {
  smoother_.reset();
  taken_.clear();
  uses_.clear();
}

Summary IncrementalBackend::minimize(const Graph& graph, Values& values) {
  if (!answer_ || !goes_on(graph, values)) return solve_whole(graph, values);
  Values answer = values;
  try {
    if (const std::optional<Summary> summary = update(graph, answer)) {
      values.assign(answer);
      answer_ = std::move(answer);
      return *summary;
    }
  } catch (const Underdetermined&) {  // irls damps what nothing holds
  } catch (const BadNumber&) {        // irls names the factor in its summary
  }
  return solve_whole(graph, values);
}

/// This graph may be the last one, grown: what was solved then begins at its answer, and the constants are the same.
bool IncrementalBackend::goes_on(const Graph& graph, const Values& values) const {
  const auto is_new = [&](Key key) { return !answer_->contains(key) || !values.contains(key); };
  const auto agree = [&](const std::unordered_set<Key>& these, const std::unordered_set<Key>& those) {
    return std::all_of(these.begin(), these.end(), [&](Key key) { return those.count(key) != 0 || is_new(key); });
  };
  return agree(graph.fixed(), fixed_) && agree(fixed_, graph.fixed()) && begins_at(*answer_, values);
}

Summary IncrementalBackend::solve_whole(const Graph& graph, Values& values) {
  forget();
  answer_.reset();
  irls_.options = options;
  irls_.options.second_order = irls_.options.findings = false;
  const Summary summary = irls_.solve(graph, values);
  if (summary.usable()) {
    answer_ = values;
    fixed_ = graph.fixed();
  }
  return summary;
}

/// `values`: the start on entry, the answer on exit, where there is one.
std::optional<Summary> IncrementalBackend::update(const Graph& graph, Values& values) {
  const Stopwatch watch;
  const Resolved resolved(graph, values);
  Summary summary;
  summary.cost_first = resolved.cost(graph, values);
  if (!std::isfinite(summary.cost_first)) return std::nullopt;
  if (!smoother_) smoother_.emplace(how_);
  take_changes(graph, values);
  if (smoother_->size() == smoother_->graph().fixed().size()) return std::nullopt;  // irls says that nothing is free
  summary.seconds_setup = watch.seconds();
  const IncrementalStep& step = smoother_->update();
  if (!step.settled) return std::nullopt;
  summary.seconds_solve = step.seconds;
  summary.iterations = step.steps;
  smoother_->read_into(values);
  std::vector<double> gradient;
  summary.cost = GradientEvaluator(graph)(graph, resolved, values, gradient);
  summary.gradient_norm = max_norm(gradient);
  constexpr double kRounding = 1e-9;
  if (!(summary.cost <= summary.cost_first * (1 + kRounding))) return std::nullopt;
  // A factor whose numbers were changed in place costs something else here than there.
  const double difference = summary.cost - smoother_->graph().cost(values);
  if (std::abs(difference) > kRounding * (summary.cost + summary.cost_first)) return std::nullopt;
  summary.termination = Termination::converged;
  summary.rule = "every variable is near where its factors were linearised";
  const Iteration last{summary.iterations, summary.cost, summary.gradient_norm, watch.seconds()};
  if (options.trace) summary.trace.push_back(last);
  if (options.progress && !options.progress(last)) {
    summary.termination = Termination::stopped;
    summary.rule = "the progress callback asked to stop";
  }
  fixed_ = graph.fixed();
  return summary;
}

void IncrementalBackend::take_changes(const Graph& graph, const Values& values) {
  for (Taken& taken : taken_) taken.is_seen = false;
  std::vector<FactorId> come;
  for (std::size_t b = 0; b < graph.batches().size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    for (int i = 0; i < batch.size(); ++i) {
      const FactorId id = graph.id_of(static_cast<int>(b), i);
      if (taken_.size() <= static_cast<std::size_t>(id.number)) taken_.resize(static_cast<std::size_t>(id.number) + 1);
      Taken& taken = taken_[static_cast<std::size_t>(id.number)];
      const bool is_known = taken.ours.number >= 0 && taken.generation == id.generation;
      taken.is_seen = is_known && taken.weight == batch.weight(i) && taken.loss == batch.loss(i);
      if (!taken.is_seen) come.push_back(id);
    }
  }
  for (Taken& taken : taken_)
    if (!taken.is_seen && taken.ours.number >= 0) let_go(taken);
  for (const FactorId id : come) take(graph, values, id);
  std::vector<Key> unused;
  for (const auto& [key, uses] : uses_)
    if (uses == 0) unused.push_back(key);
  for (const Key key : unused) {
    smoother_->erase(key);
    uses_.erase(key);
  }
}

void IncrementalBackend::take(const Graph& graph, const Values& values, FactorId id) {
  const Graph::Place& place = graph.place(id);
  const FactorBatch& batch = *graph.batches()[static_cast<std::size_t>(place.batch)];
  for (int k = 0; k < batch.arity(); ++k) {
    const Key key = batch.keys(place.index)[k];
    const auto [it, is_new] = uses_.try_emplace(key, 0);
    if (is_new) {
      smoother_->insert_from(values, key);
      if (graph.is_fixed(key)) smoother_->fix(key);
    }
    ++it->second;
  }
  taken_[static_cast<std::size_t>(id.number)] = {id.generation, smoother_->add_from(graph, id), batch.weight(place.index),
                                                 batch.loss(place.index), true};
}

void IncrementalBackend::let_go(Taken& taken) {
  const Graph& graph = smoother_->graph();
  const Graph::Place& place = graph.place(taken.ours);
  const FactorBatch& batch = *graph.batches()[static_cast<std::size_t>(place.batch)];
  for (int k = 0; k < batch.arity(); ++k) --uses_.at(batch.keys(place.index)[k]);
  smoother_->remove(taken.ours);
  taken.ours = {};
}

}  // namespace holdfast
