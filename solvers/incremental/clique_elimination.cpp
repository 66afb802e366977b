// Which variables share a clique, and the tree of cliques.
#include <algorithm>
#include <holdfast/solvers/incremental/internal/clique_tree.hpp>

namespace holdfast::detail {
namespace {

constexpr int kMostOwn = 24;     // scalars that a clique eliminates: a change near the root must not make all of it again
constexpr int kSmallFront = 24;  // scalars of a front: two that together are no larger become one, zeros and all

}  // namespace

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

/// The columns of the variables without a clique, by their place in the order, and the cliques that they become. A clique is known by its
/// last column.
struct CliqueTree::Columns {
  explicit Columns(std::size_t n) : column(n), column_children(n), hung(n), own(n), clique_children(n), made(n, -1) {}

  std::vector<int> at;                            // place in the order → variable
  std::vector<std::vector<int>> column;           // its variables after it, by place
  std::vector<std::vector<int>> column_children;  // columns whose first variable it is
  std::vector<std::vector<int>> hung;             // orphans whose first variable it is
  std::vector<std::vector<int>> own;              // columns of the clique that ends here; none: it is part of another
  std::vector<std::vector<int>> clique_children;  // by their last columns
  std::vector<int> made;                          // the number of the clique
};

/// The variables without a clique, from their terms and the orphans' updates. Returns the culprit, or −1.
int CliqueTree::eliminate_dirty() {
  if (dirty_.empty()) return -1;
  const int n = static_cast<int>(dirty_.size());
  for (int i = 0; i < n; ++i) variables_[dirty_[i]].local = i;
  const std::vector<int> order = order_of(dirty_, orphans_);
  Columns columns(static_cast<std::size_t>(n));
  for (const int i : order) columns.at.push_back(dirty_[i]);
  for (int i = 0; i < n; ++i) variables_[columns.at[i]].local = i;
  find_structure(columns);
  join_columns(columns);
  const int culprit = make_cliques(columns);
  for (const int v : columns.at) variables_[v].local = -1;
  if (culprit >= 0)
    take_back(columns);
  else
    dirty_.clear();
  return culprit;
}

/// The structure of each column, and the tree.
void CliqueTree::find_structure(Columns& columns) {
  const int n = static_cast<int>(columns.at.size());
  for (const int orphan : orphans_) {
    int first = n;
    for (const int v : cliques_[orphan].separator) first = std::min(first, variables_[v].local);
    if (first < n)
      columns.hung[first].push_back(orphan);
    else
      roots_.push_back(orphan);
  }
  orphans_.clear();
  std::vector<int> mark(n, -1);
  for (int i = 0; i < n; ++i) {
    mark[i] = i;
    std::vector<int>& rows = columns.column[i];
    const auto add = [&](int row) {
      if (row > i && mark[row] != i) mark[row] = i, rows.push_back(row);
    };
    for (const int term : variables_[columns.at[i]].terms) {
      bool is_first = true, is_whole = true;
      for (const int v : terms_[term].variables) {
        const int place = variables_[v].local;
        is_whole = is_whole && place >= 0;
        is_first = is_first && place >= i;
      }
      if (is_whole && is_first)
        for (const int v : terms_[term].variables) add(variables_[v].local);
    }
    for (const int orphan : columns.hung[i])
      for (const int v : cliques_[orphan].separator) add(variables_[v].local);
    for (const int child : columns.column_children[i])
      for (const int row : columns.column[child]) add(row);
    std::sort(rows.begin(), rows.end());
    if (!rows.empty()) columns.column_children[rows.front()].push_back(i);
  }
}

/// Columns that become one clique: a column joins its parent's where the parent adds nothing new, or both are small.
void CliqueTree::join_columns(Columns& columns) const {
  const int n = static_cast<int>(columns.at.size());
  std::vector<int> scalars(n, 0);
  const auto append = [](std::vector<int>& to, const std::vector<int>& from) { to.insert(to.end(), from.begin(), from.end()); };
  for (int i = 0; i < n; ++i) {
    columns.own[i].push_back(i);
    scalars[i] = variables_[columns.at[i]].dim;
    int width = scalars[i];
    for (const int row : columns.column[i]) width += variables_[columns.at[row]].dim;
    for (const int child : columns.column_children[i]) {
      const bool same = columns.column[child].size() == columns.column[i].size() + 1;
      const bool small = scalars[child] + width <= kSmallFront;
      if ((same || small) && scalars[child] + scalars[i] <= kMostOwn) {
        append(columns.own[i], columns.own[child]);
        append(columns.clique_children[i], columns.clique_children[child]);
        append(columns.hung[i], columns.hung[child]);
        scalars[i] += scalars[child];
        columns.own[child].clear();
      } else {
        columns.clique_children[i].push_back(child);
      }
    }
    std::sort(columns.own[i].begin(), columns.own[i].end());
  }
}

/// From the leaves up. Returns the culprit, or −1.
int CliqueTree::make_cliques(Columns& columns) {
  for (std::size_t i = 0; i < columns.at.size(); ++i) {
    if (columns.own[i].empty()) continue;
    std::vector<int> variables, separator, children = columns.hung[i];
    for (const int place : columns.own[i]) variables.push_back(columns.at[place]);
    for (const int row : columns.column[i]) separator.push_back(columns.at[row]);
    for (const int child : columns.clique_children[i]) children.push_back(columns.made[child]);
    columns.made[i] = make_clique(variables, separator, children);
    if (columns.column[i].empty()) roots_.push_back(columns.made[i]);
    if (cliques_[columns.made[i]].k == 0) return culprit_;
  }
  return -1;
}

/// Nothing half-done: the cliques made so far come off again, and all is as it was before, dirty.
void CliqueTree::take_back(const Columns& columns) {
  const std::vector<int> variables = std::move(dirty_);
  dirty_.clear();
  const std::size_t n = columns.at.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (columns.own[i].empty()) continue;  // part of another
    const int made = columns.made[i];
    if (made < 0)
      orphans_.insert(orphans_.end(), columns.hung[i].begin(), columns.hung[i].end());
    else if (cliques_[made].parent < 0 && std::find(roots_.begin(), roots_.end(), made) == roots_.end())
      orphans_.push_back(made);
  }
  for (std::size_t i = n; i-- > 0;)
    if (columns.made[i] >= 0) take_off(columns.made[i]);
  dirty_ = variables;
}

}  // namespace holdfast::detail
