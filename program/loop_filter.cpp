#include <algorithm>
#include <holdfast/program/loop_filter.hpp>
#include <holdfast/solvers/range_consistency.hpp>
#include <limits>
#include <sstream>

namespace holdfast::program {

void LoopFilter::leave_out(Graph& graph, bool can_judge) {
  constexpr std::size_t kMostNames = 20;
  const ConsistentLoops loops = consistent_loops(graph);
  const ConsistentRanges ranges = consistent_ranges(graph);
  text_ = "pcm: " + loops.str();
  if (ranges.groups > 0) text_ += "\npcm: " + ranges.str();
  std::vector<FactorId> rejected = loops.rejected;
  rejected.insert(rejected.end(), ranges.rejected.begin(), ranges.rejected.end());
  rejected_ = rejected.size();
  for (std::size_t i = 0; i < std::min(rejected_, kMostNames); ++i) {
    const Graph::Place& place = graph.place(rejected[i]);
    text_ += (i == 0 ? "\nrejected: " : ", ") + graph.batches()[place.batch]->describe(place.index);
  }
  if (rejected_ > kMostNames) text_ += ", and " + std::to_string(rejected_ - kMostNames) + " more";
  if (rejected_ > 0 && can_judge) whole_ = graph;
  for (const FactorId id : rejected) graph.remove(id);
}

const Graph* LoopFilter::whole_if_better(const common::Task& task, const common::Instance& filtered, common::Run& run, Values& answer) {
  if (!whole_) return nullptr;
  const common::Instance all{*whole_, filtered.start, filtered.truth};
  Values without;
  common::Run other = run_task(task, all, without);
  if (!other.summary.usable()) return nullptr;
  const double with_filter = run.summary.usable() ? whole_->cost(answer) : std::numeric_limits<double>::infinity();
  const double without_filter = whole_->cost(without);
  const bool is_better = without_filter < with_filter;
  std::ostringstream text;
  text << "\npcm, " << task.backend << ": over all measurements the cost is " << with_filter << " with it and " << without_filter
       << " without it; the answer is the one " << (is_better ? "without" : "with") << " it";
  text_ += text.str();
  if (!is_better) return nullptr;
  run = std::move(other);
  answer = std::move(without);
  return &*whole_;
}

}  // namespace holdfast::program
