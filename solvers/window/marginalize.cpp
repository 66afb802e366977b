#include <algorithm>
#include <cmath>
#include <holdfast/solvers/window/marginalize.hpp>

namespace holdfast {
namespace {

constexpr double kNull = 1e-14;  // of a column's first norm: what is left of it is rounding

bool all_finite(const std::vector<double>& numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
}

double norm(const double* x, int n) {
  double largest = 0;
  for (int i = 0; i < n; ++i) largest = std::max(largest, std::abs(x[i]));
  if (largest == 0) return 0;
  double sum = 0;
  for (int i = 0; i < n; ++i) sum += (x[i] / largest) * (x[i] / largest);
  return largest * std::sqrt(sum);
}

}  // namespace

void marginalize(Graph& graph, Values& values, const std::vector<Key>& keys) {
  for (Key key : keys) values.slot(key);
  Marginalizer marginalizer;
  for (Key key : keys) {
    if (!values.contains(key)) continue;  // named twice
    marginalizer.eliminate(graph, values, key);
    values.erase(std::vector<Key>{key});
  }
}

FactorId Marginalizer::eliminate(Graph& graph, const Values& values, Key key) {
  find_factors(graph, key);
  find_neighbours(graph, values, key);
  stack(graph, values);
  const int own = neighbours_.front().column < 0 ? 0 : values.pool(neighbours_.front().slot.pool).dim();
  const int first = triangulate(0, 0, own);
  const int last = triangulate(first, own, columns_);
  const double* r = &stack_[static_cast<std::size_t>(columns_) * rows_];
  for (int row = last; row < rows_; ++row) constant_ += 0.5 * r[row] * r[row];
  for (FactorId id : factors_) graph.remove(id);
  graph.unfix(key);
  if (last == first) return {};
  write_prior(values, first, last - first);
  return graph.add(prior_);
}

void Marginalizer::drop(Graph& graph, Key key) {
  find_factors(graph, key);
  for (FactorId id : factors_) graph.remove(id);
  graph.unfix(key);
}

void Marginalizer::find_factors(const Graph& graph, Key key) {
  factors_.clear();
  for (std::size_t b = 0; b < graph.batches().size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    if (batch.size() == 0) continue;
    const Key* keys = batch.keys(0);
    const int arity = batch.arity();
    for (int i = 0; i < batch.size(); ++i, keys += arity)
      if (std::find(keys, keys + arity, key) != keys + arity) factors_.push_back(graph.id_of(static_cast<int>(b), i));
  }
}

// In the order of the values, so that a prior's variables come oldest first; the variable itself before them all.
void Marginalizer::find_neighbours(const Graph& graph, const Values& values, Key key) {
  neighbours_.clear();
  neighbours_.push_back({key, values.slot(key), 0});
  for (FactorId id : factors_) {
    const Graph::Place& place = graph.place(id);
    const FactorBatch& batch = *graph.batches()[place.batch];
    for (int k = 0; k < batch.arity(); ++k) {
      const Key other = batch.keys(place.index)[k];
      const auto known = std::find_if(neighbours_.begin(), neighbours_.end(), [&](const Neighbour& n) { return n.key == other; });
      if (known == neighbours_.end()) neighbours_.push_back({other, values.slot(other), 0});
      const PoolBase& pool = values.pool(values.slot(other).pool);
      if (pool.type() != batch.types()[k])
        fail<BadType>("factor ", batch.describe(place.index), ": key ", other, " is a ", pool.type_name(),
                      " in the values, but the factor needs a ", batch.type_names()[k]);
    }
  }
  std::sort(neighbours_.begin() + 1, neighbours_.end(), [](const Neighbour& a, const Neighbour& b) {
    return a.slot.pool != b.slot.pool ? a.slot.pool < b.slot.pool : a.slot.index < b.slot.index;
  });
  columns_ = 0;
  for (Neighbour& n : neighbours_) {
    n.column = graph.is_fixed(n.key) ? -1 : columns_;
    if (n.column >= 0) columns_ += values.pool(n.slot.pool).dim();
  }
}

int Marginalizer::column_of(Key key) const {
  return std::find_if(neighbours_.begin(), neighbours_.end(), [&](const Neighbour& n) { return n.key == key; })->column;
}

void Marginalizer::stack(const Graph& graph, const Values& values) {
  rows_ = 0;
  for (FactorId id : factors_) rows_ += graph.batches()[graph.place(id).batch]->residual_dim();
  stack_.assign(static_cast<std::size_t>(rows_) * (columns_ + 1), 0.0);
  constant_ = 0;
  int row = 0;
  for (FactorId id : factors_) {
    const Graph::Place& place = graph.place(id);
    const FactorBatch& batch = *graph.batches()[place.batch];
    stack_factor(batch, place.index, values, row);
    if (batch.factor_type() == typeid(LinearPrior)) constant_ += static_cast<const LinearPriorBatch&>(batch).prior().constant;
    row += batch.residual_dim();
  }
  scale_.resize(columns_);
  for (int c = 0; c < columns_; ++c) scale_[c] = norm(&stack_[static_cast<std::size_t>(c) * rows_], rows_);
}

// √(w ρ') [J r] of factor i into the rows from `row`; what ½ρ exceeds the quadratic by is constant.
void Marginalizer::stack_factor(const FactorBatch& batch, int i, const Values& values, int row) {
  const int m = batch.residual_dim();
  ambient_.clear();
  for (int k = 0; k < batch.arity(); ++k) {
    const Values::Slot& slot = values.slot(batch.keys(i)[k]);
    ambient_.push_back(values.pool(slot.pool).data(slot.index));
  }
  r_.resize(m);
  weights_.resize(m);
  J_.resize(static_cast<std::size_t>(m) * batch.total_dim());
  batch.evaluate_at(i, ambient_.data(), r_.data(), J_.data());
  const double cost = batch.cost_of(i, r_.data(), weights_.data());
  if (!std::isfinite(cost) || !all_finite(r_) || !all_finite(J_))
    fail<BadNumber>("factor ", batch.describe(i),
                    ": its residual or Jacobian is not finite at these values, so nothing can be kept of it; remove it first");
  constant_ += cost;
  for (int c = 0; c < m; ++c) {
    constant_ -= 0.5 * weights_[c] * r_[c] * r_[c];
    weights_[c] = std::sqrt(weights_[c]);
    stack_[static_cast<std::size_t>(columns_) * rows_ + row + c] = weights_[c] * r_[c];
  }
  const double* J = J_.data();
  for (int k = 0; k < batch.arity(); J += m * batch.dims()[k++]) {
    const int column = column_of(batch.keys(i)[k]);
    if (column < 0) continue;
    for (int d = 0; d < batch.dims()[k]; ++d)
      for (int c = 0; c < m; ++c) stack_[static_cast<std::size_t>(column + d) * rows_ + row + c] = weights_[c] * J[d * m + c];
  }
}

// Columns [begin, end) to upper triangular form from first_row on; returns the row after the last pivot. The row with the largest entry
// comes first: rows of very different size then keep their digits each (Powell & Reid 1969).
int Marginalizer::triangulate(int first_row, int begin, int end) {
  const auto column = [&](int c) { return &stack_[static_cast<std::size_t>(c) * rows_]; };
  int row = first_row;
  for (int c = begin; c < end && row < rows_; ++c) {
    double* const x = column(c);
    const double size = norm(x + row, rows_ - row);
    if (!(size > kNull * scale_[c])) {
      std::fill(x + row, x + rows_, 0.0);
      continue;
    }
    const int largest =
        static_cast<int>(std::max_element(x + row, x + rows_, [](double a, double b) { return std::abs(a) < std::abs(b); }) - x);
    if (largest != row)
      for (int k = c; k <= columns_; ++k) std::swap(column(k)[row], column(k)[largest]);
    const double pivot = x[row] > 0 ? -size : size;  // v = x − pivot e₁, H = I − v vᵀ / (pivot² − pivot x₁)
    x[row] -= pivot;
    const double scale = -1 / (pivot * x[row]);
    for (int k = c + 1; k <= columns_; ++k) {
      double* const y = column(k);
      double dot = 0;
      for (int i = row; i < rows_; ++i) dot += x[i] * y[i];
      dot *= scale;
      for (int i = row; i < rows_; ++i) y[i] -= dot * x[i];
    }
    x[row] = pivot;
    std::fill(x + row + 1, x + rows_, 0.0);
    ++row;
  }
  return row;
}

void Marginalizer::write_prior(const Values& values, int first_row, int rank) {
  prior_.clear();
  prior_.rows = rank;
  prior_.constant = constant_;
  const auto append = [&](std::vector<double>& to, int c) {
    const double* from = &stack_[static_cast<std::size_t>(c) * rows_ + first_row];
    to.insert(to.end(), from, from + rank);
  };
  for (auto n = neighbours_.begin() + 1; n != neighbours_.end(); ++n) {
    if (n->column < 0) continue;
    const PoolBase& pool = values.pool(n->slot.pool);
    bool matters = false;
    for (int d = 0; d < pool.dim(); ++d) {
      const double* x = &stack_[static_cast<std::size_t>(n->column + d) * rows_ + first_row];
      matters = matters || std::any_of(x, x + rank, [](double a) { return a != 0; });
    }
    if (!matters) continue;  // no row says anything about it
    prior_.add_variable(n->key, pool.kind(), pool.data(n->slot.index));
    for (int d = 0; d < pool.dim(); ++d) append(prior_.A, n->column + d);
  }
  append(prior_.b, columns_);
}

}  // namespace holdfast
