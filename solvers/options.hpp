// What every back-end is asked for, and means the same by.
#pragma once

#include <functional>
#include <limits>

namespace holdfast {

/// One iteration, as it is traced and handed to the progress callback.
struct Iteration {
  int number;            ///< 0: the start
  double cost;           ///< Σ w ½ρ of the best values so far
  double gradient_norm;  ///< largest component of the gradient in the tangent
  double seconds;        ///< since the solve began
};

/// How the in-house second-order back-end weighs robust terms in its quadratic model (the gradient is exact either way).
///   irls:      w ρ'(s): a model that never lies below the cost near by; linear convergence.
///   newton:    w (ρ' + 2sρ''), cut off below: few iterations, kept descending by a line search.
///   automatic: newton where all losses are convex and all factors linear, else irls.
enum class Reweighting { automatic, irls, newton };

struct Options {
  int max_iterations = 0;             ///< >= 0; 0: the back-end's own: 1000, and 10,000 for first-order ones
  double cost_tolerance = 1e-6;       ///< >= 0: an accepted step that lowers the cost by less than this part of it ends the solve
  double gradient_tolerance = 1e-10;  ///< >= 0: the largest component of the gradient (tangent, whitened)
  int threads = 1;                    ///< 1 … 1024; in-house back-ends give the same bits for any number
  double time_limit = std::numeric_limits<double>::infinity();  ///< > 0 [s]; the best values so far are the answer
  Reweighting reweighting = Reweighting::automatic;             ///< of "irls"; other back-ends have their own
  bool restart = true;  ///< of "irls": where Gauss–Newton fails on a pose graph, try its chordal start, too (irls.hpp)
  bool trace = false;   ///< keep every iteration in the Summary
  std::function<bool(const Iteration&)> progress;  ///< called after each iteration; false stops the solve

  /// Throws BadOption with field, value and rule.
  void validate() const;
};

}  // namespace holdfast
