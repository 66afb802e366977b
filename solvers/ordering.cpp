#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <holdfast/solvers/ordering.hpp>
#ifdef HOLDFAST_WITH_METIS
#include <metis.h>
#endif

namespace holdfast {

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

std::vector<int> minimum_degree_order(const BlockGraph& graph) {
  using Pattern = Eigen::SparseMatrix<char>;
  Pattern adjacency(graph.size(), graph.size());
  adjacency.reserve(static_cast<Eigen::Index>(graph.neighbours.size() + graph.dims.size()));
  for (int i = 0; i < graph.size(); ++i) {
    adjacency.startVec(i);
    const auto first = graph.neighbours.begin() + graph.begin[i], last = graph.neighbours.begin() + graph.begin[i + 1];
    const auto diagonal = std::lower_bound(first, last, i);  // a node without its diagonal Eigen would take for a dense row
    for (auto j = first; j != diagonal; ++j) adjacency.insertBack(*j, i) = 1;
    adjacency.insertBack(i, i) = 1;
    for (auto j = diagonal; j != last; ++j) adjacency.insertBack(*j, i) = 1;
  }
  adjacency.finalize();
  Eigen::AMDOrdering<int>::PermutationType permutation;
  Eigen::AMDOrdering<int>()(adjacency, permutation);
  return {permutation.indices().data(), permutation.indices().data() + permutation.indices().size()};
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
