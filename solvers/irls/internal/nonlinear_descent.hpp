// Damped Gauss–Newton on the manifold: dogleg steps within a trust region, bent where residuals are curved, and a chordal restart.
// Internal.
#pragma once

#include <holdfast/solvers/internal/minimizer.hpp>
#include <holdfast/solvers/irls/internal/dogleg.hpp>
#include <holdfast/solvers/irls/internal/geodesic.hpp>
#include <holdfast/solvers/irls/irls.hpp>

namespace holdfast::detail {

class NonlinearDescent {
 public:
  NonlinearDescent(const Graph& graph, const Values& values, const NewtonSystem& system);

  struct Rules {
    Curvature curvature;
    double cost_tolerance;
    bool may_restart;
  };
  /// From `values` to the answer.
  void minimize(const Graph& graph, NewtonSystem& system, Values& values, const Rules& rules, Progress& progress);

 private:
  /// What becomes of one linearisation.
  enum class Outcome {
    full_step,   ///< a step that the radius did not make short: it lowered the cost, or costs no longer differ
    short_step,  ///< a step within the radius lowered the cost
    restarted,   ///< no step did, and the chordal start is better: the next one begins there
    over,        ///< the progress says why
  };
  /// What becomes of one step.
  enum class Try { lower, level, no_decrease_left, higher };

  struct Run;  // what one minimize() is about
  void descend(Run& run);
  double linearize(Run& run);
  Outcome step(Run& run, double gradient_norm);
  Try try_step(Run& run, Dogleg::Step& step);
  bool restart(Run& run);
  void descend_from_other_start(Run& run);

  Dogleg dogleg_;
  Geodesic geodesic_;
  TrustRegion region_;
  bool bends_ = false;  // the last step fell short of its model: the residuals are curved here
  bool may_restart_ = false;
  std::unique_ptr<Values> other_start_;  // where a second descent is to begin
  Values candidate_;
  std::vector<double> step_, tangent_;
};

}  // namespace holdfast::detail
