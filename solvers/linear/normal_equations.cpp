#include <algorithm>
#include <holdfast/solvers/linear/internal/normal_equations.hpp>

namespace holdfast {
namespace {

constexpr int kFactorsPerChunk = 16;  // their contributions stay in the first-level cache between computing and adding

void add_block(double* to, const double* block, int rows, int cols, bool transposed) {
  if (!transposed) {
    for (int k = 0; k < rows * cols; ++k) to[k] += block[k];
    return;
  }
  for (int c = 0; c < cols; ++c)
    for (int r = 0; r < rows; ++r) to[r * cols + c] += block[c * rows + r];
}

}  // namespace

NormalEquations::NormalEquations(const Graph& graph, const Resolved& resolved, const std::vector<int>& order) : order_(order) {
  std::vector<int> position(resolved.variables().size(), -1);
  for (std::size_t i = 0; i < order.size(); ++i) position[order[i]] = static_cast<int>(i);
  pattern_.offsets.push_back(0);
  for (int v : order) {
    pattern_.dims.push_back(resolved.variables()[v].dim);
    pattern_.offsets.push_back(pattern_.offsets.back() + pattern_.dims.back());
  }
  find_pattern(graph, resolved, position);
  H_.resize(pattern_.block_begin.back());
  gradient_.resize(pattern_.scalar_size());
  plans_.resize(graph.batches().size());
  std::size_t first = 0, serial = 0;
  for (std::size_t b = 0; b < plans_.size(); ++b) {
    const FactorBatch& factors = *graph.batches()[b];
    plan_batch(factors, resolved.batches()[b], position, plans_[b]);
    plans_[b].first_contribution = first;
    first += static_cast<std::size_t>(factors.size()) * factors.stride();
    serial = std::max(serial, static_cast<std::size_t>(kFactorsPerChunk) * factors.stride());
  }
  contributions_.resize(serial);
}

void NormalEquations::find_pattern(const Graph& graph, const Resolved& resolved, const std::vector<int>& position) {
  const int n = pattern_.size();
  std::vector<std::vector<int>> rows(n);
  for (int i = 0; i < n; ++i) rows[i].push_back(i);
  for (std::size_t b = 0; b < resolved.batches().size(); ++b) {
    const int arity = graph.batches()[b]->arity();
    const std::vector<int>& variable = resolved.batches()[b].variable;
    for (std::size_t f = 0; f < variable.size(); f += arity)
      for (int i = 0; i < arity; ++i)
        for (int j = 0; j < i; ++j) {
          const auto [column, row] = std::minmax(position[variable[f + i]], position[variable[f + j]]);
          if (column >= 0) rows[column].push_back(row);
        }
  }
  pattern_.column_begin.push_back(0);
  pattern_.block_begin.push_back(0);
  for (int column = 0; column < n; ++column) {
    std::sort(rows[column].begin(), rows[column].end());
    rows[column].erase(std::unique(rows[column].begin(), rows[column].end()), rows[column].end());
    for (int row : rows[column]) {
      pattern_.rows.push_back(row);
      pattern_.block_begin.push_back(pattern_.block_begin.back() + pattern_.dims[row] * pattern_.dims[column]);
    }
    pattern_.column_begin.push_back(static_cast<int>(pattern_.rows.size()));
    rows[column] = {};
  }
}

int NormalEquations::block_at(int row, int column) const {
  const auto begin = pattern_.rows.begin() + pattern_.column_begin[column];
  const auto end = pattern_.rows.begin() + pattern_.column_begin[column + 1];
  return pattern_.block_begin[std::lower_bound(begin, end, row) - pattern_.rows.begin()];
}

void NormalEquations::plan_batch(const FactorBatch& factors, const Resolved::Batch& batch, const std::vector<int>& position,
                                 Plan& plan) const {
  const std::vector<int>& dims = factors.dims();
  const int arity = factors.arity();
  for (int b = 0; b < arity; ++b)
    for (int a = b; a < arity; ++a) {
      plan.rows.push_back(dims[a]);
      plan.cols.push_back(dims[b]);
    }
  plan.rows.insert(plan.rows.end(), dims.begin(), dims.end());
  plan.cols.insert(plan.cols.end(), arity, 1);
  plan.targets.reserve(static_cast<std::size_t>(factors.size()) * plan.rows.size());
  for (std::size_t f = 0; f < batch.variable.size(); f += arity) {
    const auto at = [&](int k) { return position[batch.variable[f + k]]; };
    for (int b = 0; b < arity; ++b)
      for (int a = b; a < arity; ++a) {
        Target target;
        if (at(a) >= 0 && at(b) >= 0) target = {block_at(std::max(at(a), at(b)), std::min(at(a), at(b))), at(a) < at(b)};
        plan.targets.push_back(target);
      }
    for (int a = 0; a < arity; ++a) plan.targets.push_back({at(a) >= 0 ? pattern_.offsets[at(a)] : -1, false});
  }
}

void NormalEquations::scatter(const FactorBatch& factors, const Plan& plan, int first, int last, const double* contributions,
                              const Part& part) {
  const int n = static_cast<int>(plan.rows.size());
  const int blocks = n - factors.arity();
  for (int f = first; f < last; ++f, contributions += factors.stride()) {
    const Target* target = &plan.targets[static_cast<std::size_t>(f) * n];
    const double* block = contributions;
    for (int k = 0; k < n; ++k, ++target) {
      const int size = plan.rows[k] * plan.cols[k];
      if (k < blocks) {
        if (target->begin >= part.H_begin && target->begin < part.H_end)
          add_block(&H_[target->begin], block, plan.rows[k], plan.cols[k], target->transposed);
      } else if (target->begin >= part.gradient_begin && target->begin < part.gradient_end) {
        add_block(&gradient_[target->begin], block, size, 1, false);
      }
      block += size;
    }
  }
}

NormalEquations::Part NormalEquations::part_of(int part, int parts) const {
  const auto column_at = [&](int p) {  // columns up to here hold p/parts of H
    const auto share = static_cast<double>(H_.size()) * p / parts;
    int column = 0;
    while (column < pattern_.size() && pattern_.block_begin[pattern_.column_begin[column]] < share) ++column;
    return column;
  };
  const int first = column_at(part), last = part + 1 == parts ? pattern_.size() : column_at(part + 1);
  return {pattern_.block_begin[pattern_.column_begin[first]], pattern_.block_begin[pattern_.column_begin[last]], pattern_.offsets[first],
          pattern_.offsets[last]};
}

double NormalEquations::linearize(const Graph& graph, const Resolved& resolved, const Values& values, Curvature curvature,
                                  ThreadPool* pool) {
  return accumulate(graph, pool, [&](int b, int first, int last, double* out) {
    graph.batches()[b]->contributions(values, resolved.batches()[b].index.data(), first, last, curvature, out);
  });
}

double NormalEquations::linearize_at(const Graph& graph, const std::vector<std::vector<double>>& r,
                                     const std::vector<std::vector<double>>& J, Curvature curvature, ThreadPool* pool) {
  return accumulate(graph, pool, [&](int b, int first, int last, double* out) {
    const FactorBatch& factors = *graph.batches()[b];
    const std::size_t row = static_cast<std::size_t>(first) * factors.residual_dim();
    factors.contributions_at(r[b].data() + row, J[b].data() + row * factors.total_dim(), first, last, curvature, out);
  });
}

template <class Contribute>
double NormalEquations::accumulate(const Graph& graph, ThreadPool* pool, const Contribute& contribute) {
  std::fill(H_.begin(), H_.end(), 0.0);
  std::fill(gradient_.begin(), gradient_.end(), 0.0);
  return pool != nullptr && pool->threads() > 1 ? accumulate_in_parallel(graph, *pool, contribute) : accumulate_serially(graph, contribute);
}

template <class Contribute>
double NormalEquations::accumulate_serially(const Graph& graph, const Contribute& contribute) {
  const Part all{0, pattern_.block_begin.back(), 0, pattern_.scalar_size()};
  double cost = 0;
  for (std::size_t b = 0; b < plans_.size(); ++b) {
    const FactorBatch& factors = *graph.batches()[b];
    for (int first = 0; first < factors.size(); first += kFactorsPerChunk) {
      const int last = std::min(factors.size(), first + kFactorsPerChunk);
      contribute(static_cast<int>(b), first, last, contributions_.data());
      scatter(factors, plans_[b], first, last, contributions_.data(), all);
      for (int k = 1; k <= last - first; ++k) cost += contributions_[static_cast<std::size_t>(k) * factors.stride() - 1];
    }
  }
  return cost;
}

// First every factor's contributions, side by side in memory; then each thread adds those that fall into its columns of H,
// factor by factor as the serial code does: hence the same bits.
template <class Contribute>
double NormalEquations::accumulate_in_parallel(const Graph& graph, ThreadPool& pool, const Contribute& contribute) {
  if (!plans_.empty()) {
    const FactorBatch& last = *graph.batches().back();
    contributions_.resize(plans_.back().first_contribution + static_cast<std::size_t>(last.size()) * last.stride());
  }
  const std::vector<Chunk> chunks = chunks_of(graph, 256);
  const auto contributions_at = [&](int batch, int factor) {
    return contributions_.data() + plans_[batch].first_contribution + static_cast<std::size_t>(factor) * graph.batches()[batch]->stride();
  };
  pool.run(static_cast<int>(chunks.size()), [&](int c) {
    const Chunk& chunk = chunks[c];
    contribute(chunk.batch, chunk.first, chunk.last, contributions_at(chunk.batch, chunk.first));
  });
  pool.run(pool.threads(), [&](int t) {
    const Part part = part_of(t, pool.threads());
    for (std::size_t b = 0; b < plans_.size(); ++b)
      scatter(*graph.batches()[b], plans_[b], 0, graph.batches()[b]->size(), contributions_at(static_cast<int>(b), 0), part);
  });
  double cost = 0;
  for (std::size_t b = 0; b < plans_.size(); ++b)
    for (int f = 1; f <= graph.batches()[b]->size(); ++f) cost += *(contributions_at(static_cast<int>(b), f) - 1);
  return cost;
}

void NormalEquations::multiply(const std::vector<double>& x, std::vector<double>& y) const {
  std::fill(y.begin(), y.end(), 0.0);
  for (int column = 0; column < pattern_.size(); ++column)
    for (int k = pattern_.column_begin[column]; k < pattern_.column_begin[column + 1]; ++k) {
      const int row = pattern_.rows[k];
      const double* block = &H_[pattern_.block_begin[k]];
      const double *x_row = &x[pattern_.offsets[row]], *x_column = &x[pattern_.offsets[column]];
      double *y_row = &y[pattern_.offsets[row]], *y_column = &y[pattern_.offsets[column]];
      for (int c = 0; c < pattern_.dims[column]; ++c)
        for (int r = 0; r < pattern_.dims[row]; ++r, ++block) {
          y_row[r] += *block * x_column[c];
          if (row != column) y_column[c] += *block * x_row[r];
        }
    }
}

void NormalEquations::to_tangent(const Resolved& resolved, const double* ordered, double* tangent) const {
  for (std::size_t i = 0; i < order_.size(); ++i) {
    const Resolved::Variable& v = resolved.variables()[order_[i]];
    std::copy_n(ordered + pattern_.offsets[i], v.dim, tangent + v.offset);
  }
}

void NormalEquations::from_tangent(const Resolved& resolved, const double* tangent, double* ordered) const {
  for (std::size_t i = 0; i < order_.size(); ++i) {
    const Resolved::Variable& v = resolved.variables()[order_[i]];
    std::copy_n(tangent + v.offset, v.dim, ordered + pattern_.offsets[i]);
  }
}

}  // namespace holdfast
