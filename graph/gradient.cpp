#include <algorithm>
#include <holdfast/graph/gradient.hpp>

namespace holdfast {

GradientEvaluator::GradientEvaluator(const Graph& graph) : chunks_(chunks_of(graph, 256)) {
  std::size_t size = 0;
  for (const Chunk& chunk : chunks_) {
    begin_.push_back(size);
    size += static_cast<std::size_t>(chunk.last - chunk.first) * (graph.batches()[chunk.batch]->total_dim() + 1);
  }
  contributions_.resize(size);
}

double GradientEvaluator::operator()(const Graph& graph, const Resolved& resolved, const Values& values, std::vector<double>& gradient,
                                     ThreadPool* pool) {
  return sum(graph, resolved, gradient, pool, [&](const Chunk& chunk, double* out) {
    graph.batches()[chunk.batch]->gradients(values, resolved.batches()[chunk.batch].index.data(), chunk.first, chunk.last, out);
  });
}

void GradientEvaluator::curvature(const Graph& graph, const Resolved& resolved, const Values& values, const Values& moved, double h,
                                  const double* delta, const std::vector<std::vector<int>>& offsets, std::vector<double>& out,
                                  ThreadPool* pool) {
  sum(graph, resolved, out, pool, [&](const Chunk& chunk, double* part) {
    graph.batches()[chunk.batch]->curvatures(values, moved, h, delta, resolved.batches()[chunk.batch].index.data(),
                                             offsets[chunk.batch].data(), chunk.first, chunk.last, part);
  });
}

template <class Fill>
double GradientEvaluator::sum(const Graph& graph, const Resolved& resolved, std::vector<double>& out, ThreadPool* pool, const Fill& fill) {
  out.assign(resolved.tangent_dim(), 0.0);
  double cost = 0;
  if (pool == nullptr || pool->threads() == 1) {  // the same sums in the same order, chunk by chunk in little memory
    for (const Chunk& chunk : chunks_) {
      fill(chunk, contributions_.data());
      cost = scatter(graph, resolved, chunk, contributions_.data(), cost, out.data());
    }
    return cost;
  }
  pool->run(static_cast<int>(chunks_.size()), [&](int c) { fill(chunks_[c], &contributions_[begin_[c]]); });
  for (std::size_t c = 0; c < chunks_.size(); ++c)
    cost = scatter(graph, resolved, chunks_[c], &contributions_[begin_[c]], cost, out.data());
  return cost;
}

// Factor by factor: the order of the sum does not depend on the threads.
double GradientEvaluator::scatter(const Graph& graph, const Resolved& resolved, const Chunk& chunk, const double* part, double cost,
                                  double* out) const {
  const FactorBatch& factors = *graph.batches()[chunk.batch];
  const int arity = factors.arity();
  const int* const dims = factors.dims().data();
  const int* variable = &resolved.batches()[chunk.batch].variable[static_cast<std::size_t>(chunk.first) * arity];
  for (int f = chunk.first; f < chunk.last; ++f) {
    for (int k = 0; k < arity; ++k) {
      const int dim = dims[k], offset = resolved.variables()[*variable++].offset;
      if (offset >= 0)
        for (int i = 0; i < dim; ++i) out[offset + i] += part[i];
      part += dim;
    }
    cost += *part++;
  }
  return cost;
}

Gradient gradient(const Graph& graph, const Values& values) {
  const Resolved resolved(graph, values);
  Gradient result;
  GradientEvaluator evaluate(graph);
  evaluate(graph, resolved, values, result.value);
  for (const Resolved::Variable& v : resolved.variables()) {
    if (v.offset < 0) continue;
    result.keys.push_back(v.key);
    result.offsets.push_back(v.offset);
  }
  return result;
}

}  // namespace holdfast
