// δ down the tree, and covariances.
#include <algorithm>
#include <cmath>
#include <holdfast/solvers/incremental/internal/clique_tree.hpp>
#include <holdfast/solvers/linear/internal/dense_kernels.hpp>

namespace holdfast::detail {

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
