#include <algorithm>
#include <cmath>
#include <holdfast/solvers/linear/internal/damping.hpp>
#include <holdfast/solvers/linear/internal/linear_rows.hpp>

namespace holdfast::detail {
namespace {

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

}  // namespace

bool LinearRows::has_code_for(const std::unique_ptr<FactorBatch>& batch) {
  return !weighs_whole_blocks(*batch) || with_block_size(batch->residual_dim(), [](auto) {});
}

bool LinearRows::load(const Graph& graph, const Values& values) {
  const bool same_structure = resolved_.matches(graph, values), same = losses_are_as_before(graph) && same_structure;
  if (same && !thin_) return false;
  if (!same_structure) resolved_.rebuild(graph, values);
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

// A loss may change and the structure stay (Graph::set_loss); what weighs whole blocks has rows of its own.
bool LinearRows::losses_are_as_before(const Graph& graph) {
  bool same = whole_blocks_.size() == graph.batches().size();
  whole_blocks_.resize(graph.batches().size());
  for (std::size_t b = 0; b < whole_blocks_.size(); ++b) {
    const char whole = weighs_whole_blocks(*graph.batches()[b]) ? 1 : 0;
    same = same && whole_blocks_[b] == whole;
    whole_blocks_[b] = whole;
  }
  return same;
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
  if (batch.has_one_loss() && batch.family().kind == Loss::Kind::Huber && !batch.family().one_sided) {
    cost += weigh_huber(part, batch.family().scale, curvature);
    return;
  }
  int row = part.first_row;
  for (int i = 0; i < batch.size(); ++i)
    for (int m = 0; m < batch.residual_dim(); ++m, ++row)
      cost += row_weights<1>(batch.loss(i), weight_[row], &r_[row], 1, curvature, &gradient_weight_[row], &hessian_weight_[row]).cost;
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
    const TermWeight w =
        row_weights<M>(batch.loss(i), batch.weight(i), &r_[row], M, curvature, &gradient_weight_[row], &hessian_weight_[row]);
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
    sum += phi_of_batch(*graph.batches()[b], weight_.data() + parts_[b].first_row, r_.data() + parts_[b].first_row,
                        Jd_.data() + parts_[b].first_row, alpha);
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

}  // namespace holdfast::detail
