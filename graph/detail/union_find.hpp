// Disjoint sets of the numbers 0 … n − 1 (union–find with path halving).
#pragma once

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

namespace holdfast::detail {

class UnionFind {
 public:
  explicit UnionFind(int size) : parent_(static_cast<std::size_t>(size)) { std::iota(parent_.begin(), parent_.end(), 0); }

  /// The lowest number of its set.
  int root(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void unite(int a, int b) {
    a = root(a);
    b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<int> parent_;
};

}  // namespace holdfast::detail
