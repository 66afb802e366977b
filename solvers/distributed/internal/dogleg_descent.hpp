// Gauss–Newton by dogleg steps within a trust region, on a linearised problem wherever its parts live. Internal.
#pragma once

#include <holdfast/solvers/internal/minimizer.hpp>
#include <holdfast/solvers/irls/internal/dogleg.hpp>

namespace holdfast::detail {

/// From `values` to the answer. The stopping rules are those of irls.
void descend_by_dogleg(const Graph& graph, QuadraticModel& system, Values& values, Progress& progress);

}  // namespace holdfast::detail
