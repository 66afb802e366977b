// The terms and variables of the tree, and cliques that come off.
#include <algorithm>
#include <holdfast/solvers/incremental/internal/clique_tree.hpp>

namespace holdfast::detail {
namespace {

void drop(std::vector<int>& from, int what) { from.erase(std::find(from.begin(), from.end(), what)); }

}  // namespace

int CliqueTree::add_variable(int dim) {
  if (free_variables_.size() <= static_cast<std::size_t>(dim)) free_variables_.resize(static_cast<std::size_t>(dim) + 1);
  std::vector<int>& free = free_variables_[static_cast<std::size_t>(dim)];
  int number;
  if (free.empty()) {
    number = static_cast<int>(variables_.size());
    variables_.emplace_back();
    variables_.back().dim = dim;
    variables_.back().offset = delta_.size();
    delta_.resize(delta_.size() + static_cast<std::size_t>(dim));
    told_.resize(delta_.size());
  } else {
    number = free.back();
    free.pop_back();
  }
  restart(number);
  variables_[number].is_late = true;
  late_.push_back(number);
  dirty_.push_back(number);
  return number;
}

bool CliqueTree::is_empty() const {
  std::size_t free = 0;
  for (const std::vector<int>& list : free_variables_) free += list.size();
  return free == variables_.size();
}

void CliqueTree::restart(int variable) {
  const Variable& v = variables_[variable];
  std::fill_n(delta_.begin() + static_cast<std::ptrdiff_t>(v.offset), v.dim, 0.0);
  std::fill_n(told_.begin() + static_cast<std::ptrdiff_t>(v.offset), v.dim, 0.0);
}

double CliqueTree::moved(int variable) const {
  const Variable& v = variables_[variable];
  const double* const d = &delta_[v.offset];
  double sum = 0;
  for (const int t : v.terms) {
    const Term& term = terms_[t];
    int at = 0;
    for (const int other : term.variables) {
      if (other == variable) break;
      at += variables_[other].dim;
    }
    const std::size_t size = term.g.size();
    for (int c = 0; c < v.dim; ++c) {
      const double* const column = &term.H[static_cast<std::size_t>(at + c) * size + static_cast<std::size_t>(at)];
      for (int r = 0; r < v.dim; ++r) sum += d[r] * column[r] * d[c];
    }
  }
  return sum;
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
  free_variables_[static_cast<std::size_t>(dim)].push_back(variable);
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

}  // namespace holdfast::detail
