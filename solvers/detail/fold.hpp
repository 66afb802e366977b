// Losses that a foreign solver has not, folded into the residual exactly: r̃_c = sign(r_c) √(w ρ(r_c²)), so that ½‖r̃‖² is the cost and
// J̃ᵀr̃ its gradient. Done for per-component and one-sided losses; a loss of the whole block stays the host's own business.
#pragma once

#include <holdfast/graph/batch.hpp>

namespace holdfast {

/// True where no function of ‖r‖² is this loss.
inline bool must_fold(const Loss& loss, int residual_dim) { return loss.one_sided || (loss.per_component && residual_dim > 1); }

/// r (m) and J (m × n, column-major; may be null) become r̃ and J̃.
void fold(const Loss& loss, double weight, int m, int n, double* r, double* J);

}  // namespace holdfast
