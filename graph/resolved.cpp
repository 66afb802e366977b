#include <algorithm>
#include <holdfast/graph/resolved.hpp>

namespace holdfast {

void Resolved::rebuild(const Graph& graph, const Values& values) {
  graph_structure_ = values_structure_ = 0;  // matches nothing, should a bad key end this early
  variables_.clear();
  tangent_dim_ = residual_dim_ = 0;
  numbers_.resize(values.pools().size());
  for (std::size_t p = 0; p < numbers_.size(); ++p) numbers_[p].assign(values.pools()[p]->size(), -1);
  batches_.resize(graph.batches().size());
  for (std::size_t b = 0; b < batches_.size(); ++b) resolve_batch(graph, values, static_cast<int>(b));

  for (std::size_t p = 0; p < numbers_.size(); ++p) {
    const PoolBase& pool = values.pool(static_cast<int>(p));
    for (int i = 0; i < pool.size(); ++i) {
      if (numbers_[p][i] < 0) continue;
      numbers_[p][i] = static_cast<int>(variables_.size());
      const bool fixed = graph.is_fixed(pool.keys()[i]);
      variables_.push_back({pool.keys()[i], static_cast<int>(p), i, pool.dim(), fixed ? -1 : tangent_dim_});
      if (!fixed) tangent_dim_ += pool.dim();
    }
  }
  for (std::size_t b = 0; b < batches_.size(); ++b) {
    Batch& batch = batches_[b];
    for (std::size_t k = 0; k < batch.index.size(); ++k) batch.variable[k] = numbers_[batch.variable[k]][batch.index[k]];
  }
  graph_structure_ = graph.structure();
  values_structure_ = values.structure();
}

// Leaves the pool in `variable` for the moment, and marks the variables it meets.
void Resolved::resolve_batch(const Graph& graph, const Values& values, int b) {
  const FactorBatch& factors = *graph.batches()[b];
  const int arity = factors.arity();
  residual_dim_ += factors.size() * factors.residual_dim();
  Batch& batch = batches_[b];
  batch.index.clear();
  batch.variable.clear();
  batch.index.reserve(static_cast<std::size_t>(factors.size()) * arity);
  batch.variable.reserve(batch.index.capacity());
  for (int i = 0; i < factors.size(); ++i) {
    for (int k = 0; k < arity; ++k) {
      const Key key = factors.keys(i)[k];
      if (!values.contains(key))
        fail<BadKey>("factor ", factors.describe(i), ": key ", key, " has no value; insert a ", factors.type_names()[k],
                     " for it before solving");
      const Values::Slot slot = values.slot(key);
      const PoolBase& pool = values.pool(slot.pool);
      if (pool.type() != factors.types()[k])
        fail<BadType>("factor ", factors.describe(i), ": key ", key, " is a ", pool.type_name(), " in the values, but the factor needs a ",
                      factors.type_names()[k], "; insert it as one");
      batch.index.push_back(slot.index);
      batch.variable.push_back(slot.pool);
      numbers_[slot.pool][slot.index] = 0;
    }
  }
}

std::vector<Chunk> chunks_of(const Graph& graph, int factors_per_chunk) {
  std::vector<Chunk> chunks;
  for (std::size_t b = 0; b < graph.batches().size(); ++b)
    for (int i = 0; i < graph.batches()[b]->size(); i += factors_per_chunk)
      chunks.push_back({static_cast<int>(b), i, std::min(graph.batches()[b]->size(), i + factors_per_chunk)});
  return chunks;
}

double Resolved::cost(const Graph& graph, const Values& values, ThreadPool* pool) const {
  constexpr int kFactorsPerChunk = 512;
  const auto cost_of = [&](int b, int first, int last) { return graph.batches()[b]->cost(values, batches_[b].index.data(), first, last); };
  double total = 0;
  if (pool == nullptr || pool->threads() == 1) {  // the same sums in the same order, and nothing allocated
    for (std::size_t b = 0; b < batches_.size(); ++b) {
      const int size = graph.batches()[b]->size();
      for (int i = 0; i < size; i += kFactorsPerChunk) total += cost_of(static_cast<int>(b), i, std::min(size, i + kFactorsPerChunk));
    }
    return total;
  }
  const std::vector<Chunk> chunks = chunks_of(graph, kFactorsPerChunk);
  std::vector<double> sums(chunks.size());
  pool->run(static_cast<int>(chunks.size()), [&](int c) { sums[c] = cost_of(chunks[c].batch, chunks[c].first, chunks[c].last); });
  for (double sum : sums) total += sum;
  return total;
}

void Resolved::retract(const Values& from, const double* delta, Values& to) const {
  for (const Variable& v : variables_)
    if (v.offset >= 0) to.pool(v.pool).retract(v.index, from.pool(v.pool), delta + v.offset);
}

void Resolved::local(const Values& from, const Values& to, double* delta) const {
  for (const Variable& v : variables_)
    if (v.offset >= 0) from.pool(v.pool).local(v.index, to.pool(v.pool), delta + v.offset);
}

Resolved::Culprit Resolved::first_non_finite(const Graph& graph, const Values& values) const {
  std::vector<double> r;
  for (std::size_t b = 0; b < batches_.size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    r.resize(batch.residual_dim());
    for (int i = 0; i < batch.size(); ++i) {
      batch.evaluate(values, batches_[b].index.data(), i, i + 1, r.data(), nullptr);
      const bool residual_is_finite = std::all_of(r.begin(), r.end(), [](double x) { return std::isfinite(x); });
      if (residual_is_finite && std::isfinite(batch.cost_of(i, r.data(), nullptr))) continue;
      std::string text =
          batch.describe(i) + (residual_is_finite ? ": the square of its residual overflows at" : ": its residual is not finite at");
      for (int k = 0; k < batch.arity(); ++k) {
        const Key key = batch.keys(i)[k];
        PoolBase& pool = const_cast<PoolBase&>(values.pool(values.slot(key).pool));
        text += " " + key.str() + " = [";
        const double* x = pool.data(values.slot(key).index);
        for (int c = 0; c < pool.ambient(); ++c) text += (c ? " " : "") + std::to_string(x[c]);
        text += "]";
      }
      return {text, {batch.keys(i), batch.keys(i) + batch.arity()}};
    }
  }
  return {};
}

}  // namespace holdfast
