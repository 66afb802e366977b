#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <holdfast/solvers/linear/internal/ordering.hpp>
#ifdef HOLDFAST_WITH_METIS
#include <metis.h>
#endif

namespace holdfast {
namespace {

constexpr double kDense = 3;  // times √n neighbours

}  // namespace

BlockGraph block_graph(const Graph& graph, const Resolved& resolved, std::vector<int>& variable) {
  std::vector<int> node(resolved.variables().size(), -1);
  BlockGraph result;
  variable.clear();
  for (std::size_t v = 0; v < node.size(); ++v) {
    if (resolved.variables()[v].offset < 0) continue;
    node[v] = result.size();
    result.dims.push_back(resolved.variables()[v].dim);
    variable.push_back(static_cast<int>(v));
  }
  const auto for_each_pair = [&](const auto& visit) {
    for (std::size_t b = 0; b < resolved.batches().size(); ++b) {
      const int arity = graph.batches()[b]->arity();
      const std::vector<int>& variables = resolved.batches()[b].variable;
      for (std::size_t f = 0; f < variables.size(); f += arity)
        for (int i = 0; i < arity; ++i)
          for (int j = 0; j < arity; ++j)
            if (i != j && node[variables[f + i]] >= 0 && node[variables[f + j]] >= 0) visit(node[variables[f + i]], node[variables[f + j]]);
    }
  };
  std::vector<int> end(result.size() + 1, 0);
  for_each_pair([&](int i, int) { ++end[i + 1]; });
  for (int i = 0; i < result.size(); ++i) end[i + 1] += end[i];
  std::vector<int> all(end.back());
  std::vector<int> next(end.begin(), end.end() - 1);
  for_each_pair([&](int i, int j) { all[next[i]++] = j; });
  for (int i = 0; i < result.size(); ++i) {
    const auto first = all.begin() + end[i], last = all.begin() + end[i + 1];
    std::sort(first, last);
    result.neighbours.insert(result.neighbours.end(), first, std::unique(first, last));
    result.begin.push_back(static_cast<int>(result.neighbours.size()));
  }
  return result;
}

// A node of very many neighbours (a beacon that every pose has heard) makes minimum degree slow, and goes last in any case.
std::vector<int> minimum_degree_order(const BlockGraph& graph) {
  const auto degree = [&](int i) { return graph.begin[i + 1] - graph.begin[i]; };
  const double most = std::max(16.0, kDense * std::sqrt(static_cast<double>(graph.size())));
  std::vector<int> number(graph.size(), -1), sparse, dense;
  for (int i = 0; i < graph.size(); ++i) {
    if (degree(i) > most) {
      dense.push_back(i);
      continue;
    }
    number[i] = static_cast<int>(sparse.size());
    sparse.push_back(i);
  }
  using Pattern = Eigen::SparseMatrix<char>;
  const auto n = static_cast<Eigen::Index>(sparse.size());
  Pattern adjacency(n, n);
  adjacency.reserve(static_cast<Eigen::Index>(graph.neighbours.size()) + n);
  for (int i = 0; i < n; ++i) {
    adjacency.startVec(i);
    const auto first = graph.neighbours.begin() + graph.begin[sparse[i]], last = graph.neighbours.begin() + graph.begin[sparse[i] + 1];
    const auto diagonal = std::lower_bound(first, last, sparse[i]);  // a node without its diagonal Eigen would take for a dense row
    const auto insert = [&](auto from, auto to) {
      for (; from != to; ++from)
        if (number[*from] >= 0) adjacency.insertBack(number[*from], i) = 1;
    };
    insert(first, diagonal);
    adjacency.insertBack(i, i) = 1;
    insert(diagonal, last);
  }
  adjacency.finalize();
  Eigen::AMDOrdering<int>::PermutationType permutation;
  if (n > 0) Eigen::AMDOrdering<int>()(adjacency, permutation);
  std::vector<int> order;
  for (Eigen::Index i = 0; i < n; ++i) order.push_back(sparse[permutation.indices()[i]]);
  std::stable_sort(dense.begin(), dense.end(), [&](int a, int b) { return degree(a) < degree(b); });
  order.insert(order.end(), dense.begin(), dense.end());
  return order;
}

std::vector<int> nested_dissection_order(const BlockGraph& graph) {
#ifdef HOLDFAST_WITH_METIS
  if (graph.neighbours.empty()) return {};  // METIS divides by the number of edges
  idx_t n = graph.size();
  std::vector<idx_t> begin(graph.begin.begin(), graph.begin.end()), neighbours(graph.neighbours.begin(), graph.neighbours.end());
  std::vector<idx_t> weights(graph.dims.begin(), graph.dims.end()), order(graph.size()), position(graph.size());
  idx_t options[METIS_NOPTIONS];
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_SEED] = 1;
  if (METIS_NodeND(&n, begin.data(), neighbours.data(), weights.data(), options, order.data(), position.data()) != METIS_OK) return {};
  return {order.begin(), order.end()};
#else
  (void)graph;
  return {};
#endif
}

}  // namespace holdfast
