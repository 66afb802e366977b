// Paper C's own iteration against what we make of it.
#pragma once

#include <holdfast/benchmarks/papers/paper.hpp>

namespace holdfast::bench {

/// Iterations of (38)(39) as printed, of the same lifted problem with restarts, of `nesterov` and of `irls`, on the four courses.
PaperTable lifted_table();

}  // namespace holdfast::bench
