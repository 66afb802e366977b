#include <algorithm>
#include <chrono>
#include <cstdint>
#include <holdfast/graph/detail/union_find.hpp>
#include <holdfast/solvers/internal/independent_set.hpp>
#include <queue>

namespace holdfast::detail {
namespace {

using Clock = std::chrono::steady_clock;
using Conflicts = std::vector<std::vector<int>>;

/// A set of small numbers.
class Bits {
 public:
  explicit Bits(int size) : words_(static_cast<std::size_t>(size + 63) / 64, 0) {}
  void set(int i) { words_[i / 64] |= std::uint64_t{1} << (i % 64); }
  void reset(int i) { words_[i / 64] &= ~(std::uint64_t{1} << (i % 64)); }
  void keep(const Bits& other) {
    for (std::size_t w = 0; w < words_.size(); ++w) words_[w] &= other.words_[w];
  }
  void remove(const Bits& other) {
    for (std::size_t w = 0; w < words_.size(); ++w) words_[w] &= ~other.words_[w];
  }
  /// −1 where it is empty.
  int first() const {
    for (std::size_t w = 0; w < words_.size(); ++w)
      if (words_[w] != 0) return static_cast<int>(64 * w) + __builtin_ctzll(words_[w]);
    return -1;
  }

 private:
  std::vector<std::uint64_t> words_;
};

/// The node with the fewest conflicts first.
std::vector<int> greedy_set(const Conflicts& conflicts) {
  const int n = static_cast<int>(conflicts.size());
  std::vector<int> degree(n);
  std::vector<char> open(n, 1);
  using Entry = std::pair<int, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (int i = 0; i < n; ++i) queue.emplace(degree[i] = static_cast<int>(conflicts[i].size()), i);
  std::vector<int> chosen;
  while (!queue.empty()) {
    const auto [size, i] = queue.top();
    queue.pop();
    if (open[i] == 0 || size != degree[i]) continue;
    open[i] = 0;
    chosen.push_back(i);
    for (int j : conflicts[i]) {
      if (open[j] == 0) continue;
      open[j] = 0;
      for (int k : conflicts[j])
        if (open[k] != 0) queue.emplace(--degree[k], k);
    }
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

/// One member goes, two that only it kept out come, until there is no such three.
void swap_one_for_two(const Conflicts& conflicts, std::vector<int>& chosen) {
  const int n = static_cast<int>(conflicts.size());
  std::vector<char> in(n, 0);
  for (int i : chosen) in[i] = 1;
  std::vector<int> tightness(n, 0);  // conflicts with members
  for (int i : chosen)
    for (int j : conflicts[i]) ++tightness[j];
  const auto flip = [&](int i, int by) {
    in[i] = static_cast<char>(by > 0);
    for (int j : conflicts[i]) tightness[j] += by;
  };
  for (bool better = true; better;) {
    better = false;
    for (int i = 0; i < n; ++i) {
      if (in[i] == 0) continue;
      std::vector<int> loose;
      for (int j : conflicts[i])
        if (tightness[j] == 1) loose.push_back(j);
      for (std::size_t a = 0; a < loose.size() && in[i] != 0; ++a)
        for (std::size_t b = a + 1; b < loose.size(); ++b) {
          if (std::binary_search(conflicts[loose[a]].begin(), conflicts[loose[a]].end(), loose[b])) continue;
          flip(i, -1);
          flip(loose[a], 1);
          flip(loose[b], 1);
          better = true;
          break;
        }
    }
    for (int i = 0; i < n; ++i)
      if (in[i] == 0 && tightness[i] == 0) {
        flip(i, 1);
        better = true;
      }
  }
  chosen.clear();
  for (int i = 0; i < n; ++i)
    if (in[i] != 0) chosen.push_back(i);
}

/// Branch and bound in one connected part.
class Search {
 public:
  Search(const Conflicts& conflicts, std::vector<int> incumbent, Clock::time_point deadline)
      : size_(static_cast<int>(conflicts.size())), best_(std::move(incumbent)), deadline_(deadline) {
    // Nodes with many conflicts first: they are coloured, and branched on, while the set is large.
    order_.resize(size_);
    for (int i = 0; i < size_; ++i) order_[i] = i;
    std::stable_sort(order_.begin(), order_.end(), [&](int a, int b) { return conflicts[a].size() > conflicts[b].size(); });
    std::vector<int> place(size_);
    for (int p = 0; p < size_; ++p) place[order_[p]] = p;
    for (int p = 0; p < size_; ++p) {
      Bits compatible(size_), conflicting(size_);
      for (int i = 0; i < size_; ++i)
        if (i != p) compatible.set(i);
      for (int j : conflicts[order_[p]]) {
        compatible.reset(place[j]);
        conflicting.set(place[j]);
      }
      compatible_.push_back(std::move(compatible));
      conflicting_.push_back(std::move(conflicting));
    }
  }

  /// False: the time was up.
  bool run() {
    Bits all(size_);
    for (int i = 0; i < size_; ++i) all.set(i);
    expand(all);
    return in_time_;
  }
  const std::vector<int>& best() const { return best_; }

 private:
  void expand(const Bits& candidates) {
    if ((++steps_ & 63) == 0 && Clock::now() > deadline_) in_time_ = false;
    if (!in_time_) return;
    std::vector<std::pair<int, int>> coloured = colour(candidates);  // (node, colour), ascending colours
    Bits open = candidates;
    for (; !coloured.empty(); coloured.pop_back()) {
      const auto [node, bound] = coloured.back();
      if (static_cast<int>(current_.size()) + bound <= static_cast<int>(best_.size())) return;
      current_.push_back(node);
      Bits next = open;
      next.keep(compatible_[node]);
      if (next.first() >= 0)
        expand(next);
      else if (current_.size() > best_.size())
        take();
      current_.pop_back();
      if (!in_time_) return;
      open.reset(node);
    }
  }

  /// Classes of nodes that conflict with each other: of each class one at most is in the set.
  std::vector<std::pair<int, int>> colour(const Bits& candidates) const {
    std::vector<std::pair<int, int>> coloured;
    Bits left = candidates;
    for (int colour = 1; left.first() >= 0; ++colour) {
      Bits of_class = left;
      for (int i = of_class.first(); i >= 0; i = of_class.first()) {
        left.reset(i);
        of_class.reset(i);
        of_class.keep(conflicting_[i]);
        coloured.emplace_back(i, colour);
      }
    }
    return coloured;
  }

  void take() {
    best_.clear();
    for (int p : current_) best_.push_back(order_[p]);
  }

  int size_;
  std::vector<int> order_, best_, current_;
  std::vector<Bits> compatible_, conflicting_;
  Clock::time_point deadline_;
  std::uint64_t steps_ = 0;
  bool in_time_ = true;
};

/// The parts in which conflicts tie nodes; those without a conflict are a part each.
std::vector<std::vector<int>> connected_parts(const Conflicts& conflicts) {
  UnionFind sets(static_cast<int>(conflicts.size()));
  for (std::size_t i = 0; i < conflicts.size(); ++i)
    for (int j : conflicts[i]) sets.unite(static_cast<int>(i), j);
  std::vector<std::vector<int>> parts(conflicts.size());
  for (std::size_t i = 0; i < conflicts.size(); ++i) parts[sets.root(static_cast<int>(i))].push_back(static_cast<int>(i));
  return parts;
}

}  // namespace

IndependentSet largest_independent_set(const Conflicts& conflicts, double time_limit) {
  constexpr int kMostNodes = 4000;  // of an exact search: two bit sets a node
  const auto deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(time_limit));
  IndependentSet result;
  for (const std::vector<int>& part : connected_parts(conflicts)) {
    if (part.size() <= 1) {
      result.members.insert(result.members.end(), part.begin(), part.end());
      continue;
    }
    Conflicts within(part.size());
    for (std::size_t k = 0; k < part.size(); ++k) {
      for (int j : conflicts[part[k]]) within[k].push_back(static_cast<int>(std::lower_bound(part.begin(), part.end(), j) - part.begin()));
      std::sort(within[k].begin(), within[k].end());
    }
    std::vector<int> chosen = greedy_set(within);
    swap_one_for_two(within, chosen);
    if (static_cast<int>(part.size()) <= kMostNodes && time_limit > 0) {
      Search search(within, std::move(chosen), deadline);
      result.is_exact = search.run() && result.is_exact;
      chosen = search.best();
    } else {
      result.is_exact = false;
    }
    for (int k : chosen) result.members.push_back(part[k]);
  }
  std::sort(result.members.begin(), result.members.end());
  return result;
}

}  // namespace holdfast::detail
