// In what order the variables without a clique are eliminated.
#include <algorithm>
#include <holdfast/solvers/incremental/internal/clique_tree.hpp>
#include <holdfast/solvers/linear/internal/ordering.hpp>
#include <holdfast/solvers/linear/internal/symbolic.hpp>

namespace holdfast::detail {
namespace {

constexpr int kSmallProblem = 24;    // variables that are ordered by hand
constexpr int kWholeProblem = 1000;  // variables from which on nested dissection pays

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
  std::vector<int> order = n > kWholeProblem ? analyze(graph).order : minimum_degree_order(graph);
  std::stable_partition(order.begin(), order.end(), [&](int i) { return !late[i]; });
  return order;
}

}  // namespace holdfast::detail
