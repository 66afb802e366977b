#include <algorithm>
#include <cmath>
#include <holdfast/solvers/linear_rows.hpp>

namespace holdfast {
namespace {

constexpr double kThin = 32;              // root mean square width of the envelope: up to here fronts do not pay
constexpr double kLeastDiagonal = 1e-12;  // an unconstrained direction must feel the damping, too

bool weighs_whole_blocks(const FactorBatch& batch) {
  return batch.loss().kind != Loss::Kind::Squared && !batch.loss().per_component && batch.residual_dim() > 1;
}

/// Calls fn(std::integral_constant<int, M>) for the block sizes that have code; false for others.
template <class Fn>
bool with_block_size(int M, const Fn& fn) {
  switch (M) {
    case 2:
      fn(std::integral_constant<int, 2>());
      return true;
    case 3:
      fn(std::integral_constant<int, 3>());
      return true;
    case 4:
      fn(std::integral_constant<int, 4>());
      return true;
    case 6:
      fn(std::integral_constant<int, 6>());
      return true;
    case 9:
      fn(std::integral_constant<int, 9>());
      return true;
    default:
      return false;
  }
}

bool has_code_for(const std::unique_ptr<FactorBatch>& batch) {
  return !weighs_whole_blocks(*batch) || with_block_size(batch->residual_dim(), [](auto) {});
}

}  // namespace

bool LinearRows::load(const Graph& graph, const Values& values) {
  const bool same = resolved_.matches(graph, values);
  if (same && !thin_) return false;
  if (!same) resolved_.rebuild(graph, values);
  evaluate(graph, values);
  if (!same || !pattern_holds()) {
    find_pattern(graph);
    order_unknowns();
    thin_ = lay_out_matrix() && std::all_of(graph.batches().begin(), graph.batches().end(), has_code_for);
    if (!thin_) return false;
    lay_out_products();
  }
  for (int e = 0; e < row_begin_[r_.size()]; ++e) value_[e] = J_[source_[e]];
  std::fill(total_.begin(), total_.end(), 0.0);
  return true;
}

void LinearRows::evaluate(const Graph& graph, const Values& values) {
  parts_.clear();
  int rows = 0, entries = 0, extra = 0;
  for (const auto& batch : graph.batches()) {
    parts_.push_back({rows, batch->size() * batch->residual_dim(), entries, extra});
    rows += batch->size() * batch->residual_dim();
    entries += batch->size() * batch->residual_dim() * batch->total_dim();
    if (weighs_whole_blocks(*batch)) extra += batch->size();
  }
  for (Part& part : parts_) part.first_extra += rows;
  r_.resize(rows);
  Jd_.resize(rows);
  weight_.resize(rows);
  J_.resize(entries);
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    weights_of_rows(*graph.batches()[b], weight_.data() + parts_[b].first_row);
    graph.batches()[b]->evaluate(values, resolved_.batches()[b].index.data(), 0, graph.batches()[b]->size(),
                                 r_.data() + parts_[b].first_row, J_.data() + parts_[b].first_jacobian);
  }
}

bool LinearRows::pattern_holds() const {
  bool holds = true;
  for (std::size_t k = 0; k < J_.size(); ++k) holds &= in_pattern_[k] || J_[k] == 0;
  return holds;
}

void LinearRows::find_pattern(const Graph& graph) {
  variable_of_.clear();
  for (std::size_t v = 0; v < resolved_.variables().size(); ++v)
    if (resolved_.variables()[v].offset >= 0) variable_of_.insert(variable_of_.end(), resolved_.variables()[v].dim, static_cast<int>(v));
  in_pattern_.assign(J_.size(), 0);
  row_begin_.assign(1, 0);
  unknown_.clear();
  source_.clear();
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    for (int i = 0; i < batch.size(); ++i)
      for (int m = 0; m < batch.residual_dim(); ++m) add_row(batch, parts_[b], i, m);
  }
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    if (!weighs_whole_blocks(batch)) continue;
    for (int i = 0; i < batch.size(); ++i) add_row(batch, parts_[b], i, -1);
  }
  value_.assign(unknown_.size(), 0.0);
  for (std::vector<double>* weights : {&gradient_weight_, &hessian_weight_}) weights->assign(row_begin_.size() - 1, 0.0);
}

// Row −1: the union of the factor's rows, whose values change with the residual; their source is a column of J.
void LinearRows::add_row(const FactorBatch& batch, const Part& part, int factor, int row) {
  const int M = batch.residual_dim(), N = batch.total_dim();
  const double* J = &J_[part.first_jacobian + static_cast<std::size_t>(factor) * M * N];
  const int* const variables = &resolved_.batches()[&part - parts_.data()].variable[static_cast<std::size_t>(factor) * batch.arity()];
  int n = 0;
  for (int k = 0; k < batch.arity(); ++k) {
    const int offset = resolved_.variables()[variables[k]].offset;
    for (int c = 0; c < batch.dims()[k]; ++c, ++n) {
      const double* column = J + static_cast<std::size_t>(n) * M;
      if (row >= 0) in_pattern_[column + row - J_.data()] = column[row] != 0 || offset < 0;
      const bool present = row >= 0 ? column[row] != 0 : std::any_of(column, column + M, [](double x) { return x != 0; });
      if (offset < 0 || !present) continue;
      unknown_.push_back(offset + c);
      source_.push_back(static_cast<int>(column - J_.data()) + std::max(row, 0));
    }
  }
  row_begin_.push_back(static_cast<int>(unknown_.size()));
}

// Cuthill–McKee on the graph of the unknowns, from an end of each connected part.
void LinearRows::order_unknowns() {
  const int n = resolved_.tangent_dim();
  rows_begin_.assign(n + 2, 0);
  for (int u : unknown_) ++rows_begin_[u + 2];
  for (int u = 0; u < n; ++u) rows_begin_[u + 2] += rows_begin_[u + 1];
  rows_of_.resize(unknown_.size());
  for (std::size_t row = 0; row + 1 < row_begin_.size(); ++row)
    for (int k = row_begin_[row]; k < row_begin_[row + 1]; ++k) rows_of_[rows_begin_[unknown_[k] + 1]++] = static_cast<int>(row);
  order_.clear();
  seen_.assign(n, 0);
  for (int start = 0; start < n; ++start) {
    if (seen_[start]) continue;
    const std::size_t first = order_.size();
    visit(start);
    const int end = order_.back();
    while (order_.size() > first) {
      seen_[order_.back()] = 0;
      order_.pop_back();
    }
    visit(end);
  }
  position_.resize(n);
  for (int i = 0; i < n; ++i) position_[order_[i]] = i;
}

void LinearRows::visit(int start) {
  std::size_t next = order_.size();
  const auto reach = [&](int u) {
    if (seen_[u]) return;
    seen_[u] = 1;
    order_.push_back(u);
  };
  reach(start);
  for (; next < order_.size(); ++next) {
    const int u = order_[next];
    for (const bool own : {true, false})  // the other unknowns of the same variable first
      for (int k = rows_begin_[u]; k < rows_begin_[u + 1]; ++k)
        for (int e = row_begin_[rows_of_[k]]; e < row_begin_[rows_of_[k] + 1]; ++e)
          if (!own || variable_of_[unknown_[e]] == variable_of_[u]) reach(unknown_[e]);
  }
}

bool LinearRows::lay_out_matrix() {
  const int n = resolved_.tangent_dim();
  for (int& u : unknown_) u = position_[u];
  first_.resize(n);
  for (int i = 0; i < n; ++i) first_[i] = i;
  for (std::size_t row = 0; row + 1 < row_begin_.size(); ++row) {
    const auto begin = unknown_.begin() + row_begin_[row], end = unknown_.begin() + row_begin_[row + 1];
    if (begin == end) continue;
    const int least = *std::min_element(begin, end);
    for (auto u = begin; u != end; ++u) first_[*u] = std::min(first_[*u], least);
  }
  double work = 0;
  for (int i = 0; i < n; ++i) work += (i - first_[i] + 1.0) * (i - first_[i] + 1.0);
  return work <= kThin * kThin * n;
}

void LinearRows::lay_out_products() {
  cholesky_.set_layout(first_);
  pair_begin_.clear();
  place_.clear();
  for (std::size_t row = 0; row + 1 < row_begin_.size(); ++row) {
    pair_begin_.push_back(static_cast<int>(place_.size()));
    for (int a = row_begin_[row]; a < row_begin_[row + 1]; ++a)
      for (int b = row_begin_[row]; b <= a; ++b)
        place_.push_back(cholesky_.place(std::max(unknown_[a], unknown_[b]), std::min(unknown_[a], unknown_[b])));
  }
  for (std::vector<double>* v : {&gradient_, &damping_, &step_, &total_, &tangent_}) v->assign(first_.size(), 0.0);
}

double LinearRows::linearize(const Graph& graph, Curvature curvature) {
  double cost = 0;
  for (std::size_t b = 0; b < parts_.size(); ++b) weigh(*graph.batches()[b], parts_[b], curvature, cost);
  std::fill(cholesky_.matrix().begin(), cholesky_.matrix().end(), 0.0);
  std::fill(gradient_.begin(), gradient_.end(), 0.0);
  for_each_row(0, r_.size(), [this, g = gradient_.data()](std::size_t row, auto n, const int* unknown, const double* value) {
    const double weighted = gradient_weight_[row] * r_[row];
    for (int e = 0; e < n; ++e) g[unknown[e]] += weighted * value[e];
  });
  add_outer_products();
  return cost;
}

// Calls visit(row, entries, unknowns, values); short rows with their number of entries as a constant, so that loops over it unroll.
template <class Visit>
void LinearRows::for_each_row(std::size_t first, std::size_t last, const Visit& visit) const {
  for (std::size_t row = first; row < last; ++row) {
    const int begin = row_begin_[row], n = row_begin_[row + 1] - begin;
    const int* const unknown = unknown_.data() + begin;
    const double* const value = value_.data() + begin;
    switch (n) {
      case 1:
        visit(row, std::integral_constant<int, 1>(), unknown, value);
        break;
      case 2:
        visit(row, std::integral_constant<int, 2>(), unknown, value);
        break;
      case 4:
        visit(row, std::integral_constant<int, 4>(), unknown, value);
        break;
      case 8:
        visit(row, std::integral_constant<int, 8>(), unknown, value);
        break;
      default:
        visit(row, n, unknown, value);
    }
  }
}

void LinearRows::add_outer_products() {
  for_each_row(0, hessian_weight_.size(), [this, H = cholesky_.matrix().data()](std::size_t row, auto n, const int*, const double* value) {
    const int* const place = place_.data() + pair_begin_[row];
    for (int a = 0, pair = 0; a < n; ++a) {
      const double scaled = hessian_weight_[row] * value[a];
      for (int b = 0; b <= a; ++b, ++pair) H[place[pair]] += scaled * value[b];
    }
  });
}

void LinearRows::weigh(const FactorBatch& batch, const Part& part, Curvature curvature, double& cost) {
  if (weighs_whole_blocks(batch)) {
    with_block_size(batch.residual_dim(), [&](auto size) { weigh_blocks<size()>(batch, part, curvature, cost); });
    return;
  }
  if (batch.loss().kind == Loss::Kind::Huber && !batch.loss().one_sided) {
    cost += weigh_huber(part, batch.loss().scale, curvature);
    return;
  }
  for (int row = part.first_row; row < part.first_row + part.rows; ++row) {
    const RowWeights<1> w = row_weights<1>(batch.loss(), weight_[row], Vector<1>(r_[row]), curvature);
    gradient_weight_[row] = w.gradient[0];
    hessian_weight_[row] = w.hessian[0];
    cost += w.cost;
  }
}

// row_weights() for the most common loss, without its branches.
double LinearRows::weigh_huber(const Part& part, double a, Curvature curvature) {
  const double beyond = curvature == Curvature::newton ? kLeastCurvature : 1;
  double cost = 0;
  for (int row = part.first_row; row < part.first_row + part.rows; ++row) {
    const double x = r_[row], size = std::abs(x), psi = std::min(size, a);
    gradient_weight_[row] = weight_[row] * (size > a ? a / size : 1.0);
    hessian_weight_[row] = gradient_weight_[row] * (size > a ? beyond : 1.0);
    cost += weight_[row] * psi * (size - 0.5 * psi);
  }
  return cost;
}

template <int M>
void LinearRows::weigh_blocks(const FactorBatch& batch, const Part& part, Curvature curvature, double& cost) {
  for (int i = 0; i < batch.size(); ++i) {
    const int row = part.first_row + i * M, extra = part.first_extra + i;
    const RowWeights<M> w = row_weights<M>(batch.loss(), batch.weight(i), Eigen::Map<const Vector<M>>(&r_[row]), curvature);
    std::copy_n(w.gradient.data(), M, &gradient_weight_[row]);
    std::copy_n(w.hessian.data(), M, &hessian_weight_[row]);
    hessian_weight_[extra] = w.rank_one;
    cost += w.cost;
    if (w.rank_one == 0) continue;
    for (int e = row_begin_[extra]; e < row_begin_[extra + 1]; ++e) {
      value_[e] = 0;
      for (int m = 0; m < M; ++m) value_[e] += r_[row + m] * J_[source_[e] + m];
    }
  }
}

double LinearRows::solve_damped(double lambda) {
  for (int i = 0; i < cholesky_.size(); ++i) {
    damping_[i] = lambda * std::max(cholesky_.diagonal(i), kLeastDiagonal);
    step_[i] = -gradient_[i];
  }
  if (!cholesky_.factor(damping_)) return NAN;
  cholesky_.solve(step_);
  double predicted = 0;
  for (int i = 0; i < cholesky_.size(); ++i) predicted += 0.5 * step_[i] * (damping_[i] * step_[i] - gradient_[i]);
  return predicted;
}

void LinearRows::apply_step(const Graph&) {
  for_each_row(0, r_.size(), [this, step = step_.data()](std::size_t row, auto n, const int* unknown, const double* value) {
    double sum = 0;
    for (int e = 0; e < n; ++e) sum += value[e] * step[unknown[e]];
    Jd_[row] = sum;
  });
}

Phi LinearRows::phi(const Graph& graph, double alpha) const {
  Phi sum;
  for (std::size_t b = 0; b < parts_.size(); ++b)
    sum += phi_of_rows(graph.batches()[b]->loss(), parts_[b].rows, graph.batches()[b]->residual_dim(), weight_.data() + parts_[b].first_row,
                       r_.data() + parts_[b].first_row, Jd_.data() + parts_[b].first_row, alpha);
  return sum;
}

void LinearRows::move_along(double alpha) {
  for (std::size_t row = 0; row < r_.size(); ++row) r_[row] += alpha * Jd_[row];
  for (std::size_t i = 0; i < step_.size(); ++i) total_[i] += alpha * step_[i];
}

void LinearRows::retract(Values& values) {
  for (std::size_t i = 0; i < order_.size(); ++i) tangent_[order_[i]] = total_[i];
  resolved_.retract(values, tangent_.data(), values);
}

}  // namespace holdfast
