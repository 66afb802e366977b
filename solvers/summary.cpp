#include <holdfast/solvers/summary.hpp>
#include <sstream>

namespace holdfast {

const char* to_string(Termination termination) {
  switch (termination) {
    case Termination::converged:
      return "converged";
    case Termination::iteration_limit:
      return "iteration limit";
    case Termination::time_limit:
      return "time limit";
    case Termination::stopped:
      return "stopped";
    case Termination::failed:
      return "failed";
  }
  return "failed";
}

const char* to_string(Minimum minimum) {
  static const char* const names[] = {"second-order minimum", "left a saddle", "not checked"};
  return names[static_cast<int>(minimum)];
}

std::string Summary::str() const {
  std::ostringstream text;
  text.precision(9);
  text << to_string(termination) << " (" << why() << "): cost " << cost_first << " -> " << cost << " in " << iterations << " iterations, "
       << seconds << " s";
  if (is_convex) text << ", convex";
  if (decrement >= 0) text << ", at most about " << decrement << " above the minimum";
  if (minimum != Minimum::not_checked) text << ", " << to_string(minimum);
  if (saddles_left > 0) text << ", saddles left: " << saddles_left;
  return text.str();
}

}  // namespace holdfast
