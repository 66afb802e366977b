// One clique: its front is assembled and factored, and what it hands up is made.
#include <algorithm>
#include <cmath>
#include <holdfast/solvers/incremental/internal/clique_tree.hpp>
#include <holdfast/solvers/linear/internal/dense_kernels.hpp>
#include <holdfast/solvers/linear/internal/symbolic.hpp>

namespace holdfast::detail {
namespace {

constexpr double kLeastPivot = 1e-13;  // of the diagonal entry: less is what rounding leaves of nothing

}  // namespace

int CliqueTree::make_clique(const std::vector<int>& own, const std::vector<int>& separator, const std::vector<int>& children) {
  const int number = new_clique();
  Clique& clique = cliques_[number];
  clique.own = own;
  clique.separator = separator;
  clique.children = children;
  for (const int v : own) variables_[v].clique = number;
  for (const int child : children) cliques_[child].parent = number;
  make_front(number);
  return number;
}

/// False, and the clique's k is 0, where it is not positive definite: then culprit_ says which variable.
bool CliqueTree::make_front(int number) {
  Clique& clique = cliques_[number];
  lay_out(clique);
  find_terms(clique);
  assemble_own(clique);
  fresh_.push_back(number);
  const int k = clique.k, n = clique.n, m = n - k;
  diagonal_.resize(k);
  for (int i = 0; i < k; ++i) diagonal_[i] = clique.panel[static_cast<std::size_t>(i) * (clique.ld + 1)];
  bool is_definite = dense::factor_panel(n, k, clique.panel.data(), clique.ld);
  for (int i = 0; i < k && is_definite; ++i) {
    const double pivot = clique.panel[static_cast<std::size_t>(i) * (clique.ld + 1)];
    is_definite = pivot * pivot > kLeastPivot * diagonal_[i];
  }
  if (!is_definite) {
    culprit_ = weakest(clique);
    clique.k = 0;
    return false;
  }
  work_ += front_flops(k, n);
  if (m > 0) {
    dense::negative_outer(m, k, clique.panel.data() + k, clique.ld, clique.update.data(), clique.update_ld, 0, m);
    for (const int term : front_terms_) add_term_to(clique, terms_[term], Part::separator);
    for (const int child : clique.children) add_update_to(clique, cliques_[child], Part::separator);
  }
  dense::forward(n, k, clique.panel.data(), clique.ld, clique.y.data());
  return true;
}

void CliqueTree::assemble_own(Clique& clique) {
  for (const int term : front_terms_) add_term_to(clique, terms_[term], Part::own);
  for (const int child : clique.children) add_update_to(clique, cliques_[child], Part::own);
}

/// The variable of the first pivot that is not positive, to rounding.
int CliqueTree::weakest(Clique& clique) {
  std::fill(clique.panel.begin(), clique.panel.end(), 0.0);
  assemble_own(clique);
  const auto at = [&](int row, int column) -> double& { return clique.panel[static_cast<std::size_t>(column) * clique.ld + row]; };
  int scalar = 0;
  for (const int v : clique.own)
    for (int i = 0; i < variables_[v].dim; ++i, ++scalar) {
      const double whole = at(scalar, scalar);
      double pivot = whole;
      for (int c = 0; c < scalar; ++c) pivot -= at(scalar, c) * at(scalar, c);
      if (!(pivot > kLeastPivot * whole)) return v;
      at(scalar, scalar) = std::sqrt(pivot);
      for (int row = scalar + 1; row < clique.k; ++row) {
        for (int c = 0; c < scalar; ++c) at(row, scalar) -= at(row, c) * at(scalar, c);
        at(row, scalar) /= at(scalar, scalar);
      }
    }
  return clique.own.front();
}

void CliqueTree::lay_out(Clique& clique) {
  ++front_;
  scalar_of_.resize(variables_.size());
  in_front_.resize(variables_.size(), 0);
  clique.n = 0;
  const auto place = [&](int v) {
    scalar_of_[v] = clique.n;
    in_front_[v] = front_;
    clique.n += variables_[v].dim;
  };
  for (const int v : clique.own) place(v);
  clique.k = clique.n;
  for (const int v : clique.separator) place(v);
  const int k = clique.k, n = clique.n, m = n - k;
  clique.ld = dense::leading_dimension(n);
  clique.panel.assign(static_cast<std::size_t>(clique.ld) * k + 4, 0);
  clique.y.assign(n + 4, 0);
  clique.update_ld = m > 0 ? dense::leading_dimension(m) : 0;
  clique.update.resize(static_cast<std::size_t>(clique.update_ld) * m + 4);
}

/// Those of which a variable is eliminated here, and none below.
void CliqueTree::find_terms(const Clique& clique) {
  front_terms_.clear();
  for (const int v : clique.own)
    for (const int t : variables_[v].terms) {
      Term& term = terms_[t];
      if (term.assembled == updates_) continue;
      if (!std::all_of(term.variables.begin(), term.variables.end(), [&](int u) { return in_front_[u] == front_; })) continue;
      term.assembled = updates_;
      front_terms_.push_back(t);
    }
}

/// Its [row] is the entry of the front, row ≥ column.
double* CliqueTree::column_of(Clique& clique, int column) {
  if (column < clique.k) return clique.panel.data() + static_cast<std::ptrdiff_t>(column) * clique.ld;
  return clique.update.data() + static_cast<std::ptrdiff_t>(column - clique.k) * clique.update_ld - clique.k;
}

/// The columns of the front that are the clique's own, with b, or those of the separator.
void CliqueTree::add_term_to(Clique& clique, const Term& term, Part part) {
  const int size = static_cast<int>(term.g.size());
  int column = 0;
  for (const int a : term.variables)
    for (int i = 0; i < variables_[a].dim; ++i, ++column) {
      const int c = scalar_of_[a] + i;
      if (part == Part::own) clique.y[c] -= term.g[column];
      if ((c < clique.k) != (part == Part::own)) continue;
      const double* from = &term.H[static_cast<std::size_t>(column) * size];
      double* const to = column_of(clique, c);
      for (const int b : term.variables)
        for (int j = 0; j < variables_[b].dim; ++j, ++from)
          if (const int r = scalar_of_[b] + j; r >= c) to[r] += *from;
    }
}

/// The same of what a child hands up.
void CliqueTree::add_update_to(Clique& clique, const Clique& child, Part part) {
  const int m = child.n - child.k;
  to_.resize(m);
  int row = 0;
  for (const int v : child.separator)
    for (int i = 0; i < variables_[v].dim; ++i) to_[row++] = scalar_of_[v] + i;
  if (part == Part::own)
    for (int c = 0; c < m; ++c) clique.y[to_[c]] += child.y[child.k + c];
  const bool in_order = std::is_sorted(to_.begin(), to_.end());  // else the separator was eliminated in another order before
  for (int c = 0; c < m; ++c) {
    const double* from = &child.update[static_cast<std::size_t>(c) * child.update_ld];
    if (in_order) {
      if ((to_[c] < clique.k) != (part == Part::own)) continue;
      double* const column = column_of(clique, to_[c]);
      for (int r = c; r < m; ++r) column[to_[r]] += from[r];
      continue;
    }
    for (int r = c; r < m; ++r) {
      const int low = std::min(to_[c], to_[r]), high = std::max(to_[c], to_[r]);
      if ((low < clique.k) == (part == Part::own)) column_of(clique, low)[high] += from[r];
    }
  }
}

}  // namespace holdfast::detail
