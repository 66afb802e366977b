#include <algorithm>
#include <holdfast/solvers/linear/internal/symbolic.hpp>
#include <numeric>

namespace holdfast {
namespace {

// Nested dissection takes about as long as this many multiply–add pairs a node; below that it cannot pay.
constexpr double kDissectionFlopsPerNode = 2e4;

// Seconds that a front of n rows and k columns takes, as measured: a fixed part, arithmetic that runs faster in wider fronts, and the
// traffic of zeroing and adding up its update.
double seconds_of_front(double k, double n) {
  const double m = n - k;
  return 1.5e-7 + front_flops(static_cast<int>(k), static_cast<int>(n)) * (k + 10) / (k * 2.0e10) + 6e-10 * m * m + 4e-10 * n * k;
}

struct Node {
  std::vector<int> columns;  // positions in the given order
  std::vector<int> rows;     // positions below the columns, sorted
  std::vector<int> children;
  int parent = -1;
  double k = 0, n = 0;
};

// Fundamental supernodes: column j joins its only child when it adds no row to it.
class Tree {
 public:
  Tree(const BlockGraph& graph, const std::vector<int>& order) : graph_(graph), order_(order), position_(order.size()) {
    for (std::size_t i = 0; i < order.size(); ++i) position_[order[i]] = static_cast<int>(i);
    std::vector<std::vector<int>> pending(order.size());  // supernodes whose first row is this column
    std::vector<int> mark(order.size(), -1);
    for (int j = 0; j < static_cast<int>(order.size()); ++j) {
      const int s = eliminate(j, pending[j], mark);
      if (!nodes_[s].rows.empty()) pending[nodes_[s].rows.front()].push_back(s);
      pending[j] = {};
    }
    for (std::size_t s = 0; s < nodes_.size(); ++s)
      if (!nodes_[s].rows.empty()) {
        nodes_[s].parent = owner_[nodes_[s].rows.front()];
        nodes_[nodes_[s].parent].children.push_back(static_cast<int>(s));
      }
  }

  std::vector<int> postorder() const {
    std::vector<int> order, stack;
    for (std::size_t s = nodes_.size(); s-- > 0;)
      if (nodes_[s].parent < 0 && !nodes_[s].columns.empty()) stack.push_back(static_cast<int>(s));
    while (!stack.empty()) {  // parents first, then reversed
      const int s = stack.back();
      stack.pop_back();
      order.push_back(s);
      stack.insert(stack.end(), nodes_[s].children.begin(), nodes_[s].children.end());
    }
    std::reverse(order.begin(), order.end());
    return order;
  }

  /// Merges children into parents where that is cheaper.
  void amalgamate() {
    for (int s : postorder()) {
      Node& parent = nodes_[s];
      std::vector<int> candidates = std::move(parent.children);
      parent.children.clear();
      std::sort(candidates.begin(), candidates.end(), [&](int a, int b) {
        return nodes_[a].rows.size() > nodes_[b].rows.size() || (nodes_[a].rows.size() == nodes_[b].rows.size() && a < b);
      });
      for (int c : candidates) {
        Node& child = nodes_[c];
        const bool merge = seconds_of_front(child.k + parent.k, child.k + parent.n) <
                           seconds_of_front(child.k, child.n) + seconds_of_front(parent.k, parent.n);
        if (!merge) {
          parent.children.push_back(c);
          continue;
        }
        parent.columns.insert(parent.columns.begin(), child.columns.begin(), child.columns.end());
        parent.k += child.k;
        parent.n += child.k;
        for (int g : child.children) nodes_[g].parent = s;
        parent.children.insert(parent.children.end(), child.children.begin(), child.children.end());
        child = Node{};
      }
    }
  }

  Symbolic result() const {
    Symbolic symbolic;
    const std::vector<int> post = postorder();
    std::vector<int> number(nodes_.size(), -1), place(order_.size());
    for (int s : post) {
      number[s] = static_cast<int>(symbolic.supernodes.size());
      Symbolic::Supernode supernode;
      supernode.first = static_cast<int>(symbolic.order.size());
      for (int column : nodes_[s].columns) {
        place[column] = static_cast<int>(symbolic.order.size());
        symbolic.order.push_back(order_[column]);
      }
      supernode.last = static_cast<int>(symbolic.order.size());
      supernode.k = static_cast<int>(nodes_[s].k);
      supernode.n = static_cast<int>(nodes_[s].n);
      symbolic.flops += front_flops(supernode.k, supernode.n) / 2;
      symbolic.supernodes.push_back(std::move(supernode));
    }
    for (int s : post) {
      Symbolic::Supernode& supernode = symbolic.supernodes[number[s]];
      supernode.parent = nodes_[s].parent < 0 ? -1 : number[nodes_[s].parent];
      for (int row : nodes_[s].rows) supernode.rows.push_back(place[row]);
      std::sort(supernode.rows.begin(), supernode.rows.end());
    }
    return symbolic;
  }

 private:
  /// Makes column j part of a supernode; returns which.
  int eliminate(int j, const std::vector<int>& children, std::vector<int>& mark) {
    std::vector<int> rows;
    const auto add = [&](int row) {
      if (row <= j || mark[row] == j) return;
      mark[row] = j;
      rows.push_back(row);
    };
    const int node = order_[j];
    for (int e = graph_.begin[node]; e < graph_.begin[node + 1]; ++e) add(position_[graph_.neighbours[e]]);
    for (int child : children)
      for (int row : nodes_[child].rows) add(row);
    const bool joins = children.size() == 1 && nodes_[children.front()].rows.size() == rows.size() + 1;
    const int s = joins ? children.front() : static_cast<int>(nodes_.size());
    if (!joins) nodes_.emplace_back();
    Node& supernode = nodes_[s];
    if (joins) {
      supernode.rows.erase(supernode.rows.begin());  // j itself; the others are the same rows
    } else {
      std::sort(rows.begin(), rows.end());
      supernode.rows = std::move(rows);
      for (int row : supernode.rows) supernode.n += graph_.dims[order_[row]];
      supernode.n += graph_.dims[node];
    }
    supernode.k += graph_.dims[node];
    supernode.columns.push_back(j);
    owner_.push_back(s);
    return s;
  }

  const BlockGraph& graph_;
  const std::vector<int>& order_;
  std::vector<int> position_;
  std::vector<int> owner_;  // supernode of each column
  std::vector<Node> nodes_;
};

}  // namespace

double front_flops(int k, int n) {
  const auto squares = [](double x) { return x * (x + 1) * (2 * x + 1) / 6; };
  return squares(n) - squares(n - k);
}

Symbolic analyze(const BlockGraph& graph, const std::vector<int>& order) {
  Tree tree(graph, order);
  tree.amalgamate();
  return tree.result();
}

Symbolic analyze(const BlockGraph& graph) {
  Symbolic best = analyze(graph, minimum_degree_order(graph));
  if (best.flops <= kDissectionFlopsPerNode * graph.size()) return best;
  const std::vector<int> dissection = nested_dissection_order(graph);
  if (dissection.empty()) return best;
  Symbolic other = analyze(graph, dissection);
  return other.flops < best.flops ? other : best;
}

}  // namespace holdfast
