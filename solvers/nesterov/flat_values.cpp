#include <algorithm>
#include <holdfast/solvers/nesterov/internal/flat_values.hpp>

namespace holdfast::detail {

bool FlatValues::serves(const Graph& graph, const Values& values) {
  const auto adds = [](const auto& pool) { return pool->is_vector_space() && pool->ambient() == pool->dim(); };
  for (const auto& batch : graph.batches())
    for (const std::type_index type : batch->types())
      if (!std::any_of(values.pools().begin(), values.pools().end(), [&](const auto& pool) { return pool->type() == type && adds(pool); }))
        return false;
  return true;
}

FlatValues::FlatValues(const Resolved& resolved, const Values& base) : base_(resolved.tangent_dim()) {
  for (const Resolved::Variable& v : resolved.variables()) {
    if (v.offset < 0) continue;
    const int begin = v.index * v.dim;
    if (runs_.empty() || runs_.back().pool != v.pool || runs_.back().begin + runs_.back().size != begin)
      runs_.push_back({v.pool, begin, v.offset, 0});
    runs_.back().size += v.dim;
    std::copy_n(base.pool(v.pool).data(v.index), v.dim, &base_[v.offset]);
  }
}

void FlatValues::write(const std::vector<double>& u, Values& to) const {
  for (const Run& run : runs_) {
    double* const out = to.pool(run.pool).data(0) + run.begin;
    for (int i = 0; i < run.size; ++i) out[i] = base_[run.offset + i] + u[run.offset + i];
  }
}

}  // namespace holdfast::detail
