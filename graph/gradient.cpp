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
  parallel_for(pool, static_cast<int>(chunks_.size()), [&](int c) { fill(chunks_[c], &contributions_[begin_[c]]); });
  out.assign(resolved.tangent_dim(), 0.0);
  double cost = 0;
  const double* part = contributions_.data();
  for (const Chunk& chunk : chunks_) {  // factor by factor: the order of the sum does not depend on the threads
    const FactorBatch& factors = *graph.batches()[chunk.batch];
    const int* variable = &resolved.batches()[chunk.batch].variable[static_cast<std::size_t>(chunk.first) * factors.arity()];
    for (int f = chunk.first; f < chunk.last; ++f) {
      for (int k = 0; k < factors.arity(); ++k) {
        const int offset = resolved.variables()[*variable++].offset;
        for (int c = 0; c < factors.dims()[k]; ++c, ++part)
          if (offset >= 0) out[offset + c] += *part;
      }
      cost += *part++;
    }
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
