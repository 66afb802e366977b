// RangeBall and MissingDistance between points: their gradients without r and J.
#pragma once

namespace holdfast::detail {

/// Enters them; called before main() by the library itself. Returns true.
bool enter_ball_gradients();

}  // namespace holdfast::detail
