// How a solve went and why it stopped.
#pragma once

#include <holdfast/graph/check.hpp>
#include <holdfast/solvers/options.hpp>
#include <ostream>
#include <string>
#include <vector>

namespace holdfast {

enum class Termination { converged, iteration_limit, time_limit, stopped, failed };
const char* to_string(Termination termination);

/// What is known of an answer beyond its gradient (second_order.hpp).
enum class Minimum {
  minimum,      ///< of second order: no curvature below zero was found
  left_saddle,  ///< the back-end's own end was a saddle; after `saddles_left` of them the answer is a minimum
  not_checked   ///< Summary::not_checked says why
};
const char* to_string(Minimum minimum);

struct Summary {
  Termination termination = Termination::failed;
  const char* rule = "";     ///< the stopping rule that ended it (a string literal: it is never freed)
  std::string culprit;       ///< of a failure: factor, keys, values
  double cost_first = 0;     ///< Σ w ½ρ at the start, by Graph::cost
  double cost = 0;           ///< at the answer
  double gradient_norm = 0;  ///< largest component of the gradient at the answer (in the tangent)
  int iterations = 0;        ///< linearisations that led to a step, accepted or not
  int restarts = 0;          ///< other starts that the back-end tried of itself (irls: the chordal one); part of the solve and its seconds
  double seconds = 0;        ///< the whole solve() call
  double seconds_setup = 0;  ///< of it: the back-end's own problem, ordering, symbolic phase
  double seconds_linearize = 0;  ///< residuals and Jacobians
  double seconds_solve = 0;      ///< linear algebra
  bool is_convex = false;        ///< every factor and every loss is convex: what converged is the global minimum
  /// ½ gᵀ(H + λD)⁻¹ g, the decrease that Newton's model still predicts at the answer: of a convex problem what the cost lies above its
  /// minimum by, about. NaN where the back-end has no such model.
  double decrement = std::numeric_limits<double>::quiet_NaN();
  Minimum minimum = Minimum::not_checked;
  std::string not_checked = "not asked for";  ///< why, where it was not
  int saddles_left = 0;
  double seconds_second_order = 0;  ///< of looking, not of solving on; part of seconds
  std::vector<Finding> findings;    ///< of the graph at the answer, if asked for
  std::vector<Iteration> trace;     ///< if asked for

  /// True where values hold an answer no worse than the start: everything but a failure.
  bool usable() const { return termination != Termination::failed; }
  std::string why() const { return culprit.empty() ? rule : rule + (": " + culprit); }
  std::string str() const;
};

inline std::ostream& operator<<(std::ostream& out, const Summary& summary) { return out << summary.str(); }

}  // namespace holdfast
