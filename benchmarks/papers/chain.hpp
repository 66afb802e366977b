// The windows of paper A's own estimators (rivals_a.hpp): a target's states in one graph, each state seen by cameras, a motion from
// each to the next, and what is known of the first.
// The structure stays while the number of states does: numbers are exchanged in place, and a back-end uses its symbolic work again.
#pragma once

#include <holdfast/benchmarks/papers/polish.hpp>
#include <holdfast/factors/huber_measurement.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/white_acceleration.hpp>
#include <optional>
#include <vector>

namespace holdfast::bench {

struct ChainNode {
  int step;
  std::vector<std::optional<Vector<2>>> z;  ///< by camera [m]; none: missing
  WhiteAcceleration<Motion2> motion;        ///< from the node before
  Motion2 state;                            ///< the start of a solve, then its answer
};

struct ChainLosses {
  Loss measurement, motion, arrival;
};

class Chain {
 public:
  /// Q of each camera [m²], and the weight of its terms: the paper's 1/σ_i (8).
  struct Camera {
    Matrix<2, 2> Q;
    double weight = 1;
  };
  Chain(const std::vector<Camera>& cameras, ChainLosses losses) : cameras_(cameras), losses_(std::move(losses)) {}

  /// Puts these nodes and the arrival cost into graph() and values(). To a loss by component the root of the arrival matters.
  void set(const std::vector<ChainNode>& nodes, const std::optional<Prior<Motion2>>& arrival);
  /// Solves, polishes (polish.hpp), and writes the answer into the nodes, those of set().
  Summary solve(Backend& backend, std::vector<ChainNode>& nodes);

  const Graph& graph() const { return graph_; }
  const Values& values() const { return values_; }
  Key key(std::size_t node) const { return Agent('A')(node); }
  FactorId measurement(std::size_t node, std::size_t camera) const { return measurements_[node][camera]; }

 private:
  using Measurement = HuberMeasurement<Motion2>;
  void build(std::size_t nodes, bool has_arrival);
  Measurement seen(const Camera& camera, const Vector<2>& z) const;

  std::vector<Camera> cameras_;
  ChainLosses losses_;
  Graph graph_;
  Values values_;
  std::vector<std::vector<FactorId>> measurements_;
  std::vector<FactorId> motions_;
  std::optional<FactorId> arrival_;
  Polish polish_;
};

}  // namespace holdfast::bench
