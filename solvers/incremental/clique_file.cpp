// The tree as bytes: variables, terms and shape. The fronts are made again from them, by the same sums in the same order: the same bits.
#include <algorithm>
#include <holdfast/graph/error.hpp>
#include <holdfast/graph/files/binary.hpp>
#include <holdfast/solvers/incremental/internal/clique_tree.hpp>

namespace holdfast::detail {

void CliqueTree::write(io::ByteWriter& out) const {
  out.put(delta_).put(told_).put<std::uint64_t>(variables_.size());
  for (const Variable& v : variables_) out.put<std::int32_t>(v.dim).put<std::uint64_t>(v.offset).put<std::int32_t>(v.clique).put(v.terms);
  out.put<std::uint64_t>(terms_.size());
  for (const Term& term : terms_) out.put(term.variables).put(term.H).put(term.g);
  out.put<std::uint64_t>(cliques_.size());
  for (const Clique& clique : cliques_) out.put(clique.own).put(clique.separator).put<std::int32_t>(clique.parent).put(clique.children);
  out.put<std::uint64_t>(free_variables_.size());
  for (const std::vector<int>& list : free_variables_) out.put(list);
  for (const auto* list : {&free_terms_, &free_cliques_, &dirty_, &orphans_, &roots_, &late_}) out.put(*list);
}

CliqueTree CliqueTree::read(io::ByteReader& in) {
  CliqueTree tree;
  tree.delta_ = in.get_list<double>();
  tree.told_ = in.get_list<double>();
  for (std::size_t count = in.get_count(1); count > 0; --count) {
    Variable v;
    v.dim = in.get<std::int32_t>();
    v.offset = in.get<std::uint64_t>();
    v.clique = in.get<std::int32_t>();
    v.terms = in.get_list<int>();
    tree.variables_.push_back(std::move(v));
  }
  for (std::size_t count = in.get_count(1); count > 0; --count) {
    Term term;
    term.variables = in.get_list<int>();
    term.H = in.get_list<double>();
    term.g = in.get_list<double>();
    tree.terms_.push_back(std::move(term));
  }
  for (std::size_t count = in.get_count(1); count > 0; --count) {
    Clique clique;
    clique.own = in.get_list<int>();
    clique.separator = in.get_list<int>();
    clique.parent = in.get<std::int32_t>();
    clique.children = in.get_list<int>();
    tree.cliques_.push_back(std::move(clique));
  }
  for (std::size_t count = in.get_count(1); count > 0; --count) tree.free_variables_.push_back(in.get_list<int>());
  for (auto* list : {&tree.free_terms_, &tree.free_cliques_, &tree.dirty_, &tree.orphans_, &tree.roots_, &tree.late_})
    *list = in.get_list<int>();
  tree.require_sound();
  tree.make_fronts();
  return tree;
}

/// Throws BadFile where numbers name what is not there, or the shape is no tree.
void CliqueTree::require_sound() {
  const auto require = [](bool claim, const char* what) {
    if (!claim) fail<BadFile>("its tree of cliques is wrong: ", what);
  };
  const auto all_below = [&](const std::vector<int>& list, std::size_t size, const char* what) {
    for (const int i : list) require(i >= 0 && static_cast<std::size_t>(i) < size, what);
    std::vector<int> sorted = list;
    std::sort(sorted.begin(), sorted.end());
    require(std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end(), what);
  };
  require(told_.size() == delta_.size(), "a step without the one that was followed");
  const int no_clique = -1, cliques = static_cast<int>(cliques_.size());
  std::vector<int> owner(variables_.size(), no_clique);
  for (int c = 0; c < cliques; ++c) {
    const Clique& clique = cliques_[c];
    all_below(clique.own, variables_.size(), "a variable of a clique");
    all_below(clique.separator, variables_.size(), "a variable of a separator");
    all_below(clique.children, cliques_.size(), "a child");
    require(clique.parent >= no_clique && clique.parent < cliques, "a parent");
    for (const int child : clique.children) require(cliques_[child].parent == c && !cliques_[child].own.empty(), "a child of another");
    require(!clique.own.empty() || (clique.separator.empty() && clique.children.empty()), "a clique that eliminates nothing");
    for (const int v : clique.own) {
      require(owner[v] == no_clique, "a variable of two cliques");
      owner[v] = c;
    }
  }
  for (std::size_t i = 0; i < variables_.size(); ++i) {
    const Variable& v = variables_[i];
    require(v.dim > 0 && v.offset <= delta_.size() && static_cast<std::size_t>(v.dim) <= delta_.size() - v.offset, "a variable's place");
    require(static_cast<std::size_t>(v.dim) < free_variables_.size(), "a dimension");
    require(v.clique == owner[i], "a variable's clique");
    all_below(v.terms, terms_.size(), "a variable's term");
    for (const int t : v.terms) {
      const std::vector<int>& all = terms_[t].variables;
      require(std::find(all.begin(), all.end(), static_cast<int>(i)) != all.end(), "a term of another variable");
    }
  }
  for (const Term& term : terms_) {
    all_below(term.variables, variables_.size(), "a term's variable");
    std::size_t n = 0;
    for (const int v : term.variables) n += static_cast<std::size_t>(variables_[v].dim);
    require(term.g.size() == n && term.H.size() == n * n, "a term's size");
  }
  all_below(free_terms_, terms_.size(), "a free term");
  all_below(free_cliques_, cliques_.size(), "a free clique");
  all_below(dirty_, variables_.size(), "a variable without a clique");
  all_below(late_, variables_.size(), "a late variable");
  all_below(orphans_, cliques_.size(), "a clique without a parent");
  all_below(roots_, cliques_.size(), "a root");
  for (std::size_t dim = 0; dim < free_variables_.size(); ++dim) {
    all_below(free_variables_[dim], variables_.size(), "a free variable");
    for (const int v : free_variables_[dim])
      require(owner[v] == no_clique && variables_[v].terms.empty() && variables_[v].dim == static_cast<int>(dim), "a free variable in use");
  }
  for (const int t : free_terms_) require(terms_[t].variables.empty(), "a free term in use");
  for (const int c : free_cliques_) require(cliques_[c].own.empty(), "a free clique in use");
  for (const int v : dirty_) require(owner[v] == no_clique, "a variable without a clique that has one");
  for (const int v : late_) variables_[v].is_late = true;
}

/// The fronts of all cliques, from the leaves up.
void CliqueTree::make_fronts() {
  std::vector<int> down, stack = roots_;
  stack.insert(stack.end(), orphans_.begin(), orphans_.end());
  std::vector<char> seen(cliques_.size(), 0);
  while (!stack.empty()) {
    const int c = stack.back();
    stack.pop_back();
    if (seen[c] != 0) fail<BadFile>("its tree of cliques is wrong: two ways lead to one clique");
    seen[c] = 1;
    down.push_back(c);
    stack.insert(stack.end(), cliques_[c].children.begin(), cliques_[c].children.end());
  }
  const auto live = std::count_if(cliques_.begin(), cliques_.end(), [](const Clique& c) { return !c.own.empty(); });
  if (live != static_cast<std::ptrdiff_t>(down.size())) fail<BadFile>("its tree of cliques is wrong: a clique hangs on nothing");
  ++updates_;
  for (auto c = down.rbegin(); c != down.rend(); ++c) {
    // What a child hands up must find its place in the front.
    const Clique& clique = cliques_[*c];
    for (const int child : clique.children)
      for (const int v : cliques_[child].separator)
        if (std::find(clique.own.begin(), clique.own.end(), v) == clique.own.end() &&
            std::find(clique.separator.begin(), clique.separator.end(), v) == clique.separator.end())
          fail<BadFile>("its tree of cliques is wrong: a child hands up what its parent does not have");
    if (!make_front(*c)) fail<BadFile>("its tree of cliques is wrong: a front is not positive definite");
  }
  fresh_.clear();
}

}  // namespace holdfast::detail
