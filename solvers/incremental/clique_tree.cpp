// The terms and variables of the tree, and cliques that come off.
#include <algorithm>
#include <holdfast/solvers/incremental/internal/clique_tree.hpp>

namespace holdfast::detail {
namespace {

void drop(std::vector<int>& from, int what) { from.erase(std::find(from.begin(), from.end(), what)); }

}  // namespace

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

}  // namespace holdfast::detail
