// What the solvers see of a problem that is spread over processes, or that one process has as a whole. Internal.
#pragma once

#include <holdfast/graph/resolved.hpp>
#include <holdfast/solvers/distributed/distributed_graph.hpp>
#include <holdfast/solvers/distributed/internal/exchange.hpp>

namespace holdfast::detail {

class DistributedProblem {
 public:
  /// ghosts_are_constants: in the Resolved of this process, as for methods in which each moves its own variables alone.
  DistributedProblem(DistributedGraph& graph, bool ghosts_are_constants);
  /// All of it in one process.
  DistributedProblem(const Graph& graph, Values& values);

  const Communicator& communicator() const { return *communicator_; }
  const Graph& graph() const { return *graph_; }
  Values& values() { return *values_; }
  Exchange& exchange() { return *exchange_; }
  const Resolved& resolved() const { return resolved_; }
  bool owns(const Resolved::Variable& v) const {
    return v.pool < static_cast<int>(own_variables_.size()) && v.index < own_variables_[v.pool];
  }
  /// Of each batch: the first so many factors count here, the others are copies.
  const std::vector<int>& own_factors() const { return own_factors_; }
  std::int64_t total_tangent_dim() const { return total_tangent_dim_; }

  /// Σ w ½ρ of all processes' factors; ghosts must be current.
  double cost(const Values& values, ThreadPool* pool) const;
  /// The part of this process.
  double own_cost(const Values& values, ThreadPool* pool) const;
  /// Ghosts of these values.
  void update(Values& values) { exchange_->update(*communicator_, values); }
  std::string first_non_finite(const Values& values) const;

 private:
  void finish();

  std::unique_ptr<Communicator> alone_;
  std::unique_ptr<Exchange> nobody_;
  const Communicator* communicator_;
  const Graph* graph_;
  Values* values_;
  Exchange* exchange_;
  Resolved resolved_;
  std::vector<int> own_variables_;  // of each pool
  std::vector<int> own_factors_;
  std::int64_t total_tangent_dim_ = 0;
};

}  // namespace holdfast::detail
