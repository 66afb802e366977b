#include <algorithm>
#include <atomic>
#include <holdfast/solvers/linear/internal/block_cholesky.hpp>
#include <holdfast/solvers/linear/internal/dense_kernels.hpp>
#include <map>

namespace holdfast {
namespace {

constexpr int kSlack = 16;              // doubles behind each matrix: the kernels read past the last column by up to one vector
constexpr int kTasks = 16;              // subtrees of at most this part of the work are tasks of their own
constexpr int kColumnsPerTask = 64;     // of a large update that several threads share
constexpr double kParallelFront = 2e6;  // multiply–adds from which an update is shared

// First-fit memory planning: where each update lives while it lives.
class ArenaPlanner {
 public:
  explicit ArenaPlanner(std::size_t begin) : end_(begin) {}
  std::size_t take(std::size_t size) {
    for (auto it = free_.begin(); it != free_.end(); ++it) {
      if (it->second < size) continue;
      const std::size_t at = it->first, rest = it->second - size;
      free_.erase(it);
      if (rest > 0) free_[at + size] = rest;
      return at;
    }
    const std::size_t at = end_;
    end_ += size;
    return at;
  }
  void give(std::size_t at, std::size_t size) {
    auto next = free_.upper_bound(at);
    if (next != free_.end() && next->first == at + size) {
      size += next->second;
      next = free_.erase(next);
    }
    if (next != free_.begin() && std::prev(next)->first + std::prev(next)->second == at)
      std::prev(next)->second += size;
    else
      free_[at] = size;
  }
  std::size_t end() const { return end_; }

 private:
  std::map<std::size_t, std::size_t> free_;
  std::size_t end_;
};

}  // namespace

BlockCholesky::BlockCholesky(Symbolic symbolic, const BlockPattern& pattern) : symbolic_(std::move(symbolic)), pattern_(pattern) {
  make_fronts(pattern_);
  make_tasks();
  plan_arena();
  int largest = 0;
  for (const Front& front : fronts_) largest = std::max(largest, front.n);
  work_.resize(largest + kSlack);
}

void BlockCholesky::make_fronts(const BlockPattern& pattern) {
  std::size_t panels = 0;
  fronts_.resize(symbolic_.supernodes.size());
  std::vector<int> local(pattern.size());  // scalar row of each block in the front at hand
  for (std::size_t s = 0; s < fronts_.size(); ++s) {
    const Symbolic::Supernode& supernode = symbolic_.supernodes[s];
    Front& front = fronts_[s];
    front.k = supernode.k;
    front.n = supernode.n;
    front.m = front.n - front.k;
    front.ld = dense::leading_dimension(front.n);
    front.update_ld = dense::leading_dimension(front.m);
    front.panel = panels;
    panels += static_cast<std::size_t>(front.ld) * front.k + kSlack;
    front.first_scalar = pattern.offsets[supernode.first];
    front.parent = supernode.parent;
    if (front.parent >= 0) fronts_[front.parent].children.push_back(static_cast<int>(s));

    int row = 0;
    for (int block = supernode.first; block < supernode.last; row += pattern.dims[block++]) local[block] = row;
    for (int block : supernode.rows) {
      local[block] = row;
      row += pattern.dims[block];
      auto& runs = front.row_runs;
      if (!runs.empty() && runs.back().first + runs.back().second == pattern.offsets[block])
        runs.back().second += pattern.dims[block];
      else
        runs.emplace_back(pattern.offsets[block], pattern.dims[block]);
    }
    front.first_block = pattern.column_begin[supernode.first];
    for (int column = supernode.first; column < supernode.last; ++column)
      for (int b = pattern.column_begin[column]; b < pattern.column_begin[column + 1]; ++b)
        front.block_places.push_back(local[pattern.rows[b]] + local[column] * front.ld);
    for (int c : front.children) {
      int from = 0;
      std::vector<Run>& runs = fronts_[c].runs;
      for (int block : symbolic_.supernodes[c].rows) {
        const int length = pattern.dims[block];
        if (!runs.empty() && runs.back().to + runs.back().length == local[block])
          runs.back().length += length;
        else
          runs.push_back({from, local[block], length});
        from += length;
      }
    }
  }
  panels_.resize(panels);
}

// A subtree whose work is small enough becomes one task; what is above runs after all of them, front by front.
void BlockCholesky::make_tasks() {
  std::vector<double> work(fronts_.size());
  for (std::size_t s = 0; s < fronts_.size(); ++s) {
    work[s] += front_flops(fronts_[s].k, fronts_[s].n) + 1000;
    if (fronts_[s].parent >= 0) work[fronts_[s].parent] += work[s];
  }
  double total = 0;
  for (std::size_t s = 0; s < fronts_.size(); ++s)
    if (fronts_[s].parent < 0) total += work[s];
  std::vector<int> task(fronts_.size(), -1);
  for (std::size_t s = fronts_.size(); s-- > 0;) {  // parents before children
    const int parent = fronts_[s].parent;
    if (parent >= 0 && task[parent] >= 0)
      task[s] = task[parent];
    else if (work[s] <= total / kTasks) {
      task[s] = static_cast<int>(tasks_.size());
      tasks_.emplace_back();
    }
  }
  for (std::size_t s = 0; s < fronts_.size(); ++s) (task[s] >= 0 ? tasks_[task[s]] : top_).push_back(static_cast<int>(s));
}

void BlockCholesky::plan_arena() {
  std::size_t begin = 0;
  const auto size = [&](const Front& front) { return static_cast<std::size_t>(front.update_ld) * front.m + kSlack; };
  const auto plan = [&](const std::vector<int>& fronts, bool top) {
    ArenaPlanner planner(begin);
    for (int s : fronts) {
      fronts_[s].update = planner.take(size(fronts_[s]));
      for (int c : fronts_[s].children)
        if (!top || std::binary_search(top_.begin(), top_.end(), c)) planner.give(fronts_[c].update, size(fronts_[c]));
    }
    begin = planner.end();
  };
  for (const std::vector<int>& fronts : tasks_) plan(fronts, false);
  plan(top_, true);
  arena_.resize(begin + kSlack);
}

// Adds the columns of a child's update that are in the panel of its parent's front (own), or in the parent's update (not own).
void BlockCholesky::extend_add(const Front& child, Front& front, bool own) {
  const double* from = &arena_[child.update];
  double* panel = &panels_[front.panel];
  double* update = &arena_[front.update];
  for (std::size_t b = 0; b < child.runs.size(); ++b) {
    const Run& columns = child.runs[b];
    for (int c = 0; c < columns.length; ++c) {
      const int column = columns.to + c;
      if ((column < front.k) != own) continue;
      const double* source = from + static_cast<std::size_t>(columns.from + c) * child.update_ld;
      double* to = own ? panel + static_cast<std::size_t>(column) * front.ld
                       : update + static_cast<std::size_t>(column - front.k) * front.update_ld - front.k;
      for (int r = c; r < columns.length; ++r) to[columns.to + r] += source[columns.from + r];
      for (std::size_t a = b + 1; a < child.runs.size(); ++a) {
        const Run& rows = child.runs[a];
        for (int r = 0; r < rows.length; ++r) to[rows.to + r] += source[rows.from + r];
      }
    }
  }
}

// The own columns: H, damping, and what the children leave in them.
void BlockCholesky::assemble(Front& front, const double* H, const double* damping) {
  double* panel = &panels_[front.panel];
  std::fill_n(panel, static_cast<std::size_t>(front.ld) * front.k, 0.0);
  int b = front.first_block;
  for (int place : front.block_places) {
    const double* block = H + pattern_.block_begin[b];
    const double* end = H + pattern_.block_begin[b + 1];
    const int rows = pattern_.dims[pattern_.rows[b++]];
    for (double* to = panel + place; block < end; to += front.ld, block += rows)
      for (int r = 0; r < rows; ++r) to[r] = block[r];
  }
  if (damping != nullptr)
    for (int i = 0; i < front.k; ++i) panel[i + static_cast<std::size_t>(i) * front.ld] += damping[front.first_scalar + i];
  for (int c : front.children) extend_add(fronts_[c], front, true);
}

bool BlockCholesky::eliminate(Front& front, const double* H, const double* damping, ThreadPool* pool) {
  assemble(front, H, damping);
  double* panel = &panels_[front.panel];
  if (!dense::factor_panel(front.n, front.k, panel, front.ld)) return false;
  if (front.m == 0) return true;
  double* update = &arena_[front.update];
  const bool shared = pool != nullptr && static_cast<double>(front.m) * front.m * front.k > kParallelFront;
  const int columns = shared ? kColumnsPerTask : front.m;
  parallel_for(shared ? pool : nullptr, (front.m + columns - 1) / columns, [&](int part) {
    dense::negative_outer(front.m, front.k, panel + front.k, front.ld, update, front.update_ld, part * columns,
                          std::min(front.m, (part + 1) * columns));
  });
  for (int c : front.children) extend_add(fronts_[c], front, false);
  return true;
}

bool BlockCholesky::factor(const std::vector<double>& H, const std::vector<double>& damping, ThreadPool* pool) {
  const double* D = damping.empty() ? nullptr : damping.data();
  std::atomic<bool> positive{true};
  parallel_for(pool, static_cast<int>(tasks_.size()), [&](int t) {
    for (int s : tasks_[t])
      if (!positive || !eliminate(fronts_[s], H.data(), D, nullptr)) {
        positive = false;
        return;
      }
  });
  for (int s : top_)
    if (!positive || !eliminate(fronts_[s], H.data(), D, pool)) return false;
  return positive;
}

void BlockCholesky::solve(const std::vector<double>& b, std::vector<double>& x) {
  std::copy(b.begin(), b.end(), x.begin());
  double* work = work_.data();
  for (const Front& front : fronts_) {  // L y = b
    std::copy_n(&x[front.first_scalar], front.k, work);
    std::fill_n(work + front.k, front.m, 0.0);
    dense::forward(front.n, front.k, &panels_[front.panel], front.ld, work);
    std::copy_n(work, front.k, &x[front.first_scalar]);
    const double* below = work + front.k;
    for (const auto& [first, length] : front.row_runs)
      for (int i = 0; i < length; ++i) x[first + i] += *below++;
  }
  for (std::size_t s = fronts_.size(); s-- > 0;) {  // Lᵀ x = y
    const Front& front = fronts_[s];
    double* below = std::copy_n(&x[front.first_scalar], front.k, work);
    for (const auto& [first, length] : front.row_runs) below = std::copy_n(&x[first], length, below);
    dense::backward(front.n, front.k, &panels_[front.panel], front.ld, work);
    std::copy_n(work, front.k, &x[front.first_scalar]);
  }
}

}  // namespace holdfast
