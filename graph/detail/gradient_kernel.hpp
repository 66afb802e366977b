// Gradients of factor types whose ½‖r‖² has a gradient that takes less than r and J: code of their own for what first-order methods do all
// the time. A type without one goes through its residual and Jacobian.
#pragma once

#include <holdfast/graph/batch.hpp>

namespace holdfast {

/// Of factors [first, last), one after the other: the gradient of ½‖r‖² by their tangents side by side (total_dim doubles), then ‖r‖²; of
/// the unweighted squared loss. index: as FactorBatch::evaluate().
using GradientKernel = void (*)(const FactorBatch& batch, const Values& values, const int* index, int first, int last, double* out);

/// Of this factor type; null where it has none.
GradientKernel gradient_kernel(std::type_index factor_type);
/// Called before main(); returns true.
bool enter_gradient_kernel(std::type_index factor_type, GradientKernel kernel);

}  // namespace holdfast
