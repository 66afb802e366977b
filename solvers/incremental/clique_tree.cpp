#include <algorithm>
#include <cmath>
#include <holdfast/solvers/incremental/internal/clique_tree.hpp>
#include <holdfast/solvers/linear/internal/dense_kernels.hpp>
#include <holdfast/solvers/linear/internal/ordering.hpp>
#include <holdfast/solvers/linear/internal/symbolic.hpp>

namespace holdfast::detail {
namespace {

constexpr int kMostOwn = 24;           // scalars that a clique eliminates: a change near the root must not make all of it again
constexpr int kSmallFront = 24;        // scalars of a front: two that together are no larger become one, zeros and all
constexpr double kLeastPivot = 1e-13;  // of the diagonal entry: less is what rounding leaves of nothing
constexpr int kSmallProblem = 24;      // variables that are ordered by hand

void drop(std::vector<int>& from, int what) { from.erase(std::find(from.begin(), from.end(), what)); }

/// Minimum degree by sets, for few variables; those that are late come last.
std::vector<int> small_order(std::vector<std::vector<char>> tied, const std::vector<char>& late) {
  const int n = static_cast<int>(late.size());
  std::vector<int> order;
  std::vector<char> gone(n, 0);
  while (static_cast<int>(order.size()) < n) {
    int best = -1, least = 0;
    for (int i = 0; i < n; ++i) {
      if (gone[i]) continue;
      int degree = late[i] ? 2 * n : 0;
      for (int j = 0; j < n; ++j) degree += j != i && !gone[j] && tied[i][j];
      if (best < 0 || degree < least) best = i, least = degree;
    }
    order.push_back(best);
    gone[best] = 1;
    for (int i = 0; i < n; ++i)
      if (!gone[i] && tied[best][i])
        for (int j = 0; j < n; ++j)
          if (!gone[j] && tied[best][j]) tied[i][j] = tied[j][i] = 1;
  }
  return order;
}

}  // namespace

// ---- variables and terms

int CliqueTree::add_variable(int dim) {
  int number;
  if (free_variables_.empty()) {
    number = static_cast<int>(variables_.size());
    variables_.emplace_back();
  } else {
    number = free_variables_.back();
    free_variables_.pop_back();
  }
  Variable& v = variables_[number];
  if (v.dim != dim) {
    v.offset = delta_.size();
    delta_.resize(delta_.size() + static_cast<std::size_t>(dim));
    told_.resize(delta_.size());
  }
  v.dim = dim;
  restart(number);
  v.is_late = true;
  late_.push_back(number);
  dirty_.push_back(number);
  return number;
}

void CliqueTree::restart(int variable) {
  const Variable& v = variables_[variable];
  std::fill_n(delta_.begin() + static_cast<std::ptrdiff_t>(v.offset), v.dim, 0.0);
  std::fill_n(told_.begin() + static_cast<std::ptrdiff_t>(v.offset), v.dim, 0.0);
}

void CliqueTree::remove_variable(int variable) {
  touch(variable);
  Variable& v = variables_[variable];
  drop(dirty_, variable);
  if (v.is_late) drop(late_, variable);
  const int dim = v.dim;
  const std::size_t offset = v.offset;
  v = Variable();
  v.dim = dim;
  v.offset = offset;
  free_variables_.push_back(variable);
}

int CliqueTree::add_term(const std::vector<int>& variables, const std::vector<double>& H, const std::vector<double>& g) {
  int number;
  if (free_terms_.empty()) {
    number = static_cast<int>(terms_.size());
    terms_.emplace_back();
  } else {
    number = free_terms_.back();
    free_terms_.pop_back();
  }
  terms_[number].variables = variables;
  for (const int variable : variables) {
    Variable& v = variables_[variable];
    v.terms.push_back(number);
    if (!v.is_late) {
      v.is_late = true;
      late_.push_back(variable);
    }
  }
  change_term(number, H, g);
  return number;
}

void CliqueTree::change_term(int term, const std::vector<double>& H, const std::vector<double>& g) {
  terms_[term].H = H;
  terms_[term].g = g;
  for (const int variable : terms_[term].variables) touch(variable);
}

void CliqueTree::remove_term(int term) {
  for (const int variable : terms_[term].variables) {
    touch(variable);
    drop(variables_[variable].terms, term);
  }
  terms_[term] = Term();
  free_terms_.push_back(term);
}

/// The clique of a variable and all above it come off.
void CliqueTree::touch(int variable) {
  for (int c = variables_[variable].clique; c >= 0;) {
    const int parent = cliques_[c].parent;
    take_off(c);
    c = parent;
  }
}

void CliqueTree::take_off(int number) {
  Clique& clique = cliques_[number];
  for (const int variable : clique.own) {
    variables_[variable].clique = -1;
    dirty_.push_back(variable);
  }
  for (const int child : clique.children) {
    cliques_[child].parent = -1;
    orphans_.push_back(child);
  }
  if (clique.parent >= 0)
    drop(cliques_[clique.parent].children, number);
  else if (const auto it = std::find(orphans_.begin(), orphans_.end(), number); it != orphans_.end())
    orphans_.erase(it);
  else
    drop(roots_, number);
  clique.own.clear();
  clique.separator.clear();
  clique.children.clear();
  clique.parent = -1;
  free_cliques_.push_back(number);
}

int CliqueTree::new_clique() {
  if (free_cliques_.empty()) {
    cliques_.emplace_back();
    return static_cast<int>(cliques_.size()) - 1;
  }
  const int number = free_cliques_.back();
  free_cliques_.pop_back();
  return number;
}

// ---- elimination

int CliqueTree::update(double tolerance) {
  ++updates_;
  fresh_.clear();
  changed_.clear();
  work_ = 0;
  remade_ = static_cast<int>(dirty_.size());
  const int culprit = eliminate_dirty();
  if (culprit >= 0) return culprit;
  for (const int variable : late_) variables_[variable].is_late = false;
  late_.clear();
  solve_down(tolerance);
  return -1;
}

int CliqueTree::reorder(double tolerance) {
  while (!roots_.empty()) {
    // Children become orphans, and are taken off in their turn.
    take_off(roots_.back());
    while (!orphans_.empty()) take_off(orphans_.back());
  }
  return update(tolerance);
}

std::vector<int> CliqueTree::order_of(const std::vector<int>& variables, const std::vector<int>& orphans) {
  const int n = static_cast<int>(variables.size());
  std::vector<std::vector<int>> neighbours(n);
  const auto tie = [&](const std::vector<int>& group) {
    for (const int a : group)
      for (const int b : group)
        if (a != b) neighbours[variables_[a].local].push_back(variables_[b].local);
  };
  for (const int variable : variables)
    for (const int term : variables_[variable].terms) {
      const std::vector<int>& group = terms_[term].variables;
      if (group.front() != variable) continue;  // once each
      if (std::all_of(group.begin(), group.end(), [&](int v) { return variables_[v].local >= 0; })) tie(group);
    }
  for (const int orphan : orphans) tie(cliques_[orphan].separator);
  std::vector<char> late(n);
  for (int i = 0; i < n; ++i) late[i] = variables_[variables[i]].is_late;
  if (n <= kSmallProblem) {
    std::vector<std::vector<char>> tied(n, std::vector<char>(n, 0));
    for (int i = 0; i < n; ++i)
      for (const int j : neighbours[i]) tied[i][j] = 1;
    return small_order(std::move(tied), late);
  }
  BlockGraph graph;
  for (int i = 0; i < n; ++i) {
    std::vector<int>& all = neighbours[i];
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    graph.dims.push_back(variables_[variables[i]].dim);
    graph.neighbours.insert(graph.neighbours.end(), all.begin(), all.end());
    graph.begin.push_back(static_cast<int>(graph.neighbours.size()));
  }
  constexpr int kWholeProblem = 1000;  // nested dissection pays
  std::vector<int> order = n > kWholeProblem ? analyze(graph).order : minimum_degree_order(graph);
  std::stable_partition(order.begin(), order.end(), [&](int i) { return !late[i]; });
  return order;
}

/// The variables without a clique, from their terms and the orphans' updates. Returns the culprit, or −1.
int CliqueTree::eliminate_dirty() {
  if (dirty_.empty()) return -1;
  const int n = static_cast<int>(dirty_.size());
  for (int i = 0; i < n; ++i) variables_[dirty_[i]].local = i;
  const std::vector<int> order = order_of(dirty_, orphans_);
  std::vector<int> at(n);  // place in the order → variable
  for (int i = 0; i < n; ++i) at[i] = dirty_[order[i]];
  for (int i = 0; i < n; ++i) variables_[at[i]].local = i;

  // The structure of each column, by place: its variables after it; and the tree.
  std::vector<std::vector<int>> column(n), column_children(n), hung(n);
  std::vector<int> parent(n, -1), mark(n, -1);
  for (const int orphan : orphans_) {
    int first = n;
    for (const int v : cliques_[orphan].separator) first = std::min(first, variables_[v].local);
    if (first < n)
      hung[first].push_back(orphan);
    else
      roots_.push_back(orphan);
  }
  orphans_.clear();
  for (int i = 0; i < n; ++i) {
    mark[i] = i;
    std::vector<int>& rows = column[i];
    const auto add = [&](int row) {
      if (row > i && mark[row] != i) mark[row] = i, rows.push_back(row);
    };
    for (const int term : variables_[at[i]].terms) {
      bool is_first = true, is_whole = true;
      for (const int v : terms_[term].variables) {
        const int place = variables_[v].local;
        is_whole = is_whole && place >= 0;
        is_first = is_first && place >= i;
      }
      if (is_whole && is_first)
        for (const int v : terms_[term].variables) add(variables_[v].local);
    }
    for (const int orphan : hung[i])
      for (const int v : cliques_[orphan].separator) add(variables_[v].local);
    for (const int child : column_children[i])
      for (const int row : column[child]) add(row);
    std::sort(rows.begin(), rows.end());
    if (!rows.empty()) {
      parent[i] = rows.front();
      column_children[rows.front()].push_back(i);
    }
  }

  // Columns that become one clique: a column joins its parent's where the parent adds nothing new, or both are small. From the leaves up,
  // cliques by their last column.
  std::vector<std::vector<int>> own(n), clique_children(n);
  std::vector<int> scalars(n, 0);
  int culprit = -1;
  std::vector<int> made(n, -1);
  for (int i = 0; i < n; ++i) {
    own[i].push_back(i);
    scalars[i] = variables_[at[i]].dim;
    int width = scalars[i];
    for (const int row : column[i]) width += variables_[at[row]].dim;
    for (const int child : column_children[i]) {
      // `child` is the last column of its clique; may it join?
      const bool same = column[child].size() == column[i].size() + 1;
      const bool small = scalars[child] + width <= kSmallFront;
      if ((same || small) && scalars[child] + scalars[i] <= kMostOwn && made[child] < 0) {
        own[i].insert(own[i].end(), own[child].begin(), own[child].end());
        scalars[i] += scalars[child];
        clique_children[i].insert(clique_children[i].end(), clique_children[child].begin(), clique_children[child].end());
        hung[i].insert(hung[i].end(), hung[child].begin(), hung[child].end());
        own[child].clear();
      } else {
        clique_children[i].push_back(child);
      }
    }
    std::sort(own[i].begin(), own[i].end());
  }
  for (int i = 0; i < n && culprit < 0; ++i) {
    if (own[i].empty()) continue;
    std::vector<int> variables, separator, children = hung[i];
    for (const int place : own[i]) variables.push_back(at[place]);
    for (const int row : column[i]) separator.push_back(at[row]);
    for (const int child : clique_children[i]) children.push_back(made[child]);
    made[i] = make_clique(variables, separator, children);
    if (cliques_[made[i]].k == 0) culprit = culprit_;
    if (column[i].empty()) roots_.push_back(made[i]);
  }
  for (int i = 0; i < n; ++i) variables_[at[i]].local = -1;
  if (culprit < 0) {
    dirty_.clear();
    return -1;
  }
  // Nothing half-done: the cliques made so far come off again, and all is as it was before, dirty.
  const std::vector<int> variables = dirty_;
  dirty_.clear();
  for (int i = 0; i < n; ++i) {
    if (own[i].empty()) continue;
    if (made[i] >= 0) {
      if (cliques_[made[i]].parent < 0 && std::find(roots_.begin(), roots_.end(), made[i]) == roots_.end()) orphans_.push_back(made[i]);
    } else {
      orphans_.insert(orphans_.end(), hung[i].begin(), hung[i].end());
    }
  }
  for (int i = n - 1; i >= 0; --i)
    if (made[i] >= 0) take_off(made[i]);
  dirty_ = variables;
  return culprit;
}

int CliqueTree::make_clique(const std::vector<int>& own, const std::vector<int>& separator, const std::vector<int>& children) {
  const int number = new_clique();
  Clique& clique = cliques_[number];
  clique.own = own;
  clique.separator = separator;
  clique.children = children;
  lay_out(clique);
  for (const int v : own) variables_[v].clique = number;
  for (const int child : children) cliques_[child].parent = number;
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
    return number;
  }
  work_ += front_flops(k, n);
  if (m > 0) {
    dense::negative_outer(m, k, clique.panel.data() + k, clique.ld, clique.update.data(), clique.update_ld, 0, m);
    for (const int term : front_terms_) add_term_to(clique, terms_[term], Part::separator);
    for (const int child : children) add_update_to(clique, cliques_[child], Part::separator);
  }
  dense::forward(n, k, clique.panel.data(), clique.ld, clique.y.data());
  return number;
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

// ---- solving

void CliqueTree::solve_clique(Clique& clique, std::vector<double>& x) const {
  x.resize(clique.n + 4);
  std::copy_n(clique.y.begin(), clique.k, x.begin());
  int row = clique.k;
  for (const int v : clique.separator)
    for (int i = 0; i < variables_[v].dim; ++i) x[row++] = delta_[variables_[v].offset + i];
  dense::backward(clique.n, clique.k, clique.panel.data(), clique.ld, x.data());
}

void CliqueTree::solve_down(double tolerance) {
  moved_.assign(variables_.size(), 0);
  std::vector<char> is_fresh(cliques_.size(), 0);
  for (const int c : fresh_) is_fresh[c] = 1;
  std::vector<int> stack;
  for (const int c : roots_)
    if (is_fresh[c]) stack.push_back(c);
  std::vector<double> x;
  while (!stack.empty()) {
    Clique& clique = cliques_[stack.back()];
    const bool must = is_fresh[stack.back()] != 0;
    stack.pop_back();
    if (!must && std::none_of(clique.separator.begin(), clique.separator.end(), [&](int v) { return moved_[v] != 0; })) continue;
    solve_clique(clique, x);
    int row = 0;
    for (const int v : clique.own) {
      const std::size_t offset = variables_[v].offset;
      bool is_new = false;
      double most = 0;  // since those below were told: small moves add up
      for (int i = 0; i < variables_[v].dim; ++i, ++row) {
        is_new = is_new || x[row] != delta_[offset + i];
        delta_[offset + i] = x[row];
        most = std::max(most, std::abs(x[row] - told_[offset + i]));
      }
      if (is_new) changed_.push_back(v);
      if (!(most > tolerance)) continue;
      moved_[v] = 1;
      std::copy_n(delta_.begin() + static_cast<std::ptrdiff_t>(offset), variables_[v].dim,
                  told_.begin() + static_cast<std::ptrdiff_t>(offset));
    }
    stack.insert(stack.end(), clique.children.begin(), clique.children.end());
  }
}

Eigen::MatrixXd CliqueTree::covariance(const std::vector<int>& wanted) {
  int size = 0;
  for (const int v : wanted) size += variables_[v].dim;
  Eigen::MatrixXd result(size, size);
  // L z = e along the way from a variable's clique to its root, then Lᵀ x = z down the same ways.
  std::vector<int> path;
  std::vector<char> on_path(cliques_.size(), 0);
  for (const int v : wanted)
    for (int c = variables_[v].clique; c >= 0 && !on_path[c]; c = cliques_[c].parent) on_path[c] = 1;
  std::vector<int> stack(roots_), down;
  while (!stack.empty()) {
    const int c = stack.back();
    stack.pop_back();
    if (!on_path[c]) continue;
    down.push_back(c);
    stack.insert(stack.end(), cliques_[c].children.begin(), cliques_[c].children.end());
  }
  std::vector<double> b(delta_.size(), 0), x;
  int column = 0;
  for (const int v : wanted)
    for (int i = 0; i < variables_[v].dim; ++i, ++column) {
      for (const int c : down)
        for (const int u : cliques_[c].own)
          std::fill_n(b.begin() + static_cast<std::ptrdiff_t>(variables_[u].offset), variables_[u].dim, 0.0);
      b[variables_[v].offset + i] = 1;
      const auto gather = [&](const Clique& clique) {
        x.assign(clique.n + 4, 0);
        int row = 0;
        for (const auto* part : {&clique.own, &clique.separator})
          for (const int u : *part)
            for (int j = 0; j < variables_[u].dim; ++j) x[row++] = b[variables_[u].offset + j];
      };
      const auto scatter = [&](const Clique& clique, bool own_only) {
        int row = 0;
        for (const int u : clique.own)
          for (int j = 0; j < variables_[u].dim; ++j) b[variables_[u].offset + j] = x[row++];
        if (own_only) return;
        for (const int u : clique.separator)
          for (int j = 0; j < variables_[u].dim; ++j) b[variables_[u].offset + j] = x[row++];
      };
      for (auto c = down.rbegin(); c != down.rend(); ++c) {
        const Clique& clique = cliques_[*c];
        gather(clique);
        dense::forward(clique.n, clique.k, clique.panel.data(), clique.ld, x.data());
        scatter(clique, false);
      }
      for (const int c : down) {
        const Clique& clique = cliques_[c];
        gather(clique);
        dense::backward(clique.n, clique.k, clique.panel.data(), clique.ld, x.data());
        scatter(clique, true);
      }
      int row = 0;
      for (const int u : wanted)
        for (int j = 0; j < variables_[u].dim; ++j) result(row++, column) = b[variables_[u].offset + j];
    }
  return result;
}

}  // namespace holdfast::detail
