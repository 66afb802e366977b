// The structure of a LinearRows: which entries are not 0, in what order unknowns are eliminated, where products go.
#include <algorithm>
#include <holdfast/solvers/linear/internal/linear_rows.hpp>

namespace holdfast::detail {
namespace {

constexpr double kThin = 32;  // root mean square width of the envelope: up to here fronts do not pay

}  // namespace

bool LinearRows::weighs_whole_blocks(const FactorBatch& batch) {
  return batch.family().kind != Loss::Kind::Squared && !batch.family().per_component && batch.residual_dim() > 1;
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
  unknown_.resize(2 * J_.size());  // at most: of the rows, and of the rows of whole factors
  source_.resize(unknown_.size());
  entries_ = 0;
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    for (int i = 0; i < batch.size(); ++i)
      for (int m = 0; m < batch.residual_dim(); ++m) add_row(batch, b, i, m);
  }
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    if (!weighs_whole_blocks(batch)) continue;
    for (int i = 0; i < batch.size(); ++i) add_union_of_rows(batch, b, i);
  }
  unknown_.resize(entries_);
  source_.resize(entries_);
  value_.assign(entries_, 0.0);
  for (std::vector<double>* weights : {&gradient_weight_, &hessian_weight_}) weights->assign(row_begin_.size() - 1, 0.0);
}

// Calls visit(begin, unknown) for each column of a factor's Jacobian: where it begins in J_, and its unknown; −1 of a fixed variable.
template <class Visit>
void LinearRows::for_each_column(const FactorBatch& batch, std::size_t b, int factor, const Visit& visit) const {
  const int M = batch.residual_dim();
  const int* const variables = &resolved_.batches()[b].variable[static_cast<std::size_t>(factor) * batch.arity()];
  int begin = parts_[b].first_jacobian + factor * M * batch.total_dim();
  for (int k = 0; k < batch.arity(); ++k) {
    const int offset = resolved_.variables()[variables[k]].offset;
    for (int c = 0; c < batch.dims()[k]; ++c, begin += M) visit(begin, offset < 0 ? -1 : offset + c);
  }
}

void LinearRows::add_row(const FactorBatch& batch, std::size_t b, int factor, int row) {
  for_each_column(batch, b, factor, [&](int begin, int unknown) {
    const bool present = J_[begin + row] != 0;
    in_pattern_[begin + row] = present || unknown < 0;
    if (!present || unknown < 0) return;
    unknown_[entries_] = unknown;
    source_[entries_++] = begin + row;
  });
  row_begin_.push_back(static_cast<int>(entries_));
}

// A row whose values change with the residual; the source of an entry is where its column of J begins.
void LinearRows::add_union_of_rows(const FactorBatch& batch, std::size_t b, int factor) {
  const int M = batch.residual_dim();
  for_each_column(batch, b, factor, [&](int begin, int unknown) {
    const auto column = J_.begin() + begin;
    if (unknown < 0 || std::none_of(column, column + M, [](double x) { return x != 0; })) return;
    unknown_[entries_] = unknown;
    source_[entries_++] = begin;
  });
  row_begin_.push_back(static_cast<int>(entries_));
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
  walked_.assign(row_begin_.size() - 1, 0);
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
      for (int k = rows_begin_[u]; k < rows_begin_[u + 1]; ++k) {
        const int row = rows_of_[k];
        if (walked_[row] == start + 1) continue;  // all of its unknowns have been reached
        for (int e = row_begin_[row]; e < row_begin_[row + 1]; ++e)
          if (!own || variable_of_[unknown_[e]] == variable_of_[u]) reach(unknown_[e]);
        if (!own) walked_[row] = start + 1;
      }
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

}  // namespace holdfast::detail
