// Nesterov's method where the cost is convex and the variables are of a vector space: one gradient an iteration and no other evaluation.
// Internal.
#pragma once

#include <holdfast/graph/gradient.hpp>
#include <holdfast/solvers/internal/minimizer.hpp>
#include <holdfast/solvers/nesterov/internal/chain_preconditioner.hpp>
#include <holdfast/solvers/nesterov/internal/flat_values.hpp>

namespace holdfast::detail {

/// x⁺ = y − P⁻¹∇f(y)/L,  y⁺ = x⁺ + β (x⁺ − x), in arrays that are touched twice an iteration.
/// * P: ChainPreconditioner where every pair is moved far apart, once: no factor between two points is steeper (a RangeBall's curvature is
///   at most that of its distance).
/// * L needs no search. Of a convex f with curvature at most L in the metric P, ‖Δg‖²_{P⁻¹} ≤ L Δgᵀ Δy between any two points: what two
///   iterates show is a lower bound, and L follows it.
/// * The cost of x is looked at every few iterations; where it rose, L was too small: back to the best x, with twice the L.
/// * Momentum that points uphill is dropped (O'Donoghue & Candès 2015).
class FlatDescent {
 public:
  static bool serves(const Graph& graph, const Values& values);

  /// Throws BadProblem where nothing is free.
  FlatDescent(const Graph& graph, const Values& start, ChainPreconditioner::Kept kept, int threads);

  /// `values`: the start on entry, the answer on exit.
  void minimize(Values& values, Progress& progress);

 private:
  void learn_L();
  void step();
  /// The best so far becomes x, where that costs less; false where it costs more.
  bool take_if_lower(Summary& summary);
  /// Back to the best where x costs more. False where no step lowers the cost.
  bool look(Progress& progress);

  const Graph& graph_;
  Resolved resolved_;
  GradientEvaluator evaluate_;
  ChainPreconditioner preconditioner_;
  ThreadPool pool_;
  FlatValues flat_;
  Values at_;
  std::vector<double> x_, y_, best_, g_, d_, last_y_, last_g_, last_d_;
  double t_ = 1, L_ = 1;
  bool has_last_ = false;
};

}  // namespace holdfast::detail
