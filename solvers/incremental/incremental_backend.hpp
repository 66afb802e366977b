// A back-end for one graph that grows: make_backend("incremental"). It keeps an Incremental from solve to solve, and takes in what has
// changed since the last one: factors and variables that have come or gone, other losses and weights.
//
//   const auto backend = make_backend("incremental");
//   while (…) {
//     values.insert(x(k), guess);
//     graph.add(Between<Pose2>{…}, {x(k - 1), x(k)});
//     backend->solve(graph, values);
//   }
//
// The answer of a solve that went on from the last one is that of Incremental::update(): each variable is nearer than
// IncrementalOptions::relinearize to where its factors were linearised. irls solves the whole graph, with these Options: the first time;
// where the start is not the last answer; where a factor's numbers were changed in place (Graph::at), or a variable was fixed or freed;
// and where Incremental cannot (a variable that nothing holds), or would end at a higher cost than the start's.
// Cost of a solve: what the update costs, and a few passes over factors and variables to see what has changed.
// Of Options, an update looks at progress, trace, second_order and findings alone: limits and tolerances are those of irls.
// A Window that is restored from a file has a new back-end: its answers are then the same to this accuracy, not bit by bit.
// Threads: as every back-end.
#pragma once

#include <holdfast/solvers/backend.hpp>
#include <holdfast/solvers/incremental/incremental.hpp>
#include <holdfast/solvers/irls/irls.hpp>
#include <optional>
#include <unordered_map>

namespace holdfast {

class IncrementalBackend final : public Backend {
 public:
  /// By default nearer to the batch answer than an Incremental: 0.01 sigmas.
  static IncrementalOptions accurate() {
    IncrementalOptions how;
    how.relinearize = 0.01;
    return how;
  }
  explicit IncrementalBackend(Options chosen = {}, IncrementalOptions how = accurate());
  std::string name() const override { return "incremental"; }

 protected:
  Summary minimize(const Graph& graph, Values& values) override;

 private:
  /// What the smoother has of a factor, by its number in the caller's graph.
  struct Taken {
    unsigned generation = 0;  ///< there
    FactorId ours;            ///< number −1: none
    double weight = 0;
    Loss loss;
    bool is_seen = false;
  };

  bool goes_on(const Graph& graph, const Values& values) const;
  Summary solve_whole(const Graph& graph, Values& values);
  std::optional<Summary> update(const Graph& graph, Values& values);
  void take_changes(const Graph& graph, const Values& values);
  void take(const Graph& graph, const Values& values, FactorId id);
  void let_go(Taken& taken);
  void forget();

  IncrementalOptions how_;
  Irls irls_;
  std::optional<Incremental> smoother_;
  std::vector<Taken> taken_;
  std::unordered_map<Key, int> uses_;  ///< how many factors the smoother has on each of its variables
  std::optional<Values> answer_;       ///< of the last solve
  std::unordered_set<Key> fixed_;      ///< in the last solve
};

}  // namespace holdfast
