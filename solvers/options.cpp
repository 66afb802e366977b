#include <holdfast/graph/error.hpp>
#include <holdfast/solvers/options.hpp>

namespace holdfast {

void Options::validate() const {
  if (max_iterations < 0) fail<BadOption>("max_iterations = ", max_iterations, " must be >= 0 (0: the back-end's own limit)");
  if (!(cost_tolerance >= 0)) fail<BadOption>("cost_tolerance = ", cost_tolerance, " must be >= 0");
  if (!(gradient_tolerance >= 0)) fail<BadOption>("gradient_tolerance = ", gradient_tolerance, " must be >= 0");
  if (threads < 1 || threads > 1024) fail<BadOption>("threads = ", threads, " must be between 1 and 1024");
  if (!(time_limit > 0)) fail<BadOption>("time_limit = ", time_limit, " must be > 0 [s]");
}

}  // namespace holdfast
