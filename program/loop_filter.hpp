// solve --pcm: loop closures that disagree with most others are left out before solving, and what that is worth. Ranges likewise.
#pragma once

#include <holdfast/common/run.hpp>
#include <holdfast/solvers/pairwise_consistency.hpp>
#include <optional>
#include <string>

namespace holdfast::program {

class LoopFilter {
 public:
  /// Takes the rejected loops out of the graph. can_judge: under the loss of the problem a cost over all loops says something.
  void leave_out(Graph& graph, bool can_judge);
  std::size_t rejected() const { return rejected_; }
  /// What was left out, and how each back-end fared.
  const std::string& text() const { return text_; }

  bool has_whole() const { return whole_.has_value(); }

  /// Under a loss that outliers cannot pull along, the cost over all loops says which is better, the answer with the filter or the one
  /// without; run and answer are those of the better one. Returns the whole graph where that was without it, else null.
  const Graph* whole_if_better(const common::Task& task, const common::Instance& filtered, common::Run& run, Values& answer);

 private:
  std::string text_;
  std::optional<Graph> whole_;  // where a fall-back can be judged
  std::size_t rejected_ = 0;
};

}  // namespace holdfast::program
