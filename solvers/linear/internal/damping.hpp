// What damping has in common: λ times the diagonal of H. Internal.
#pragma once

namespace holdfast::detail {

/// The least that an entry of the diagonal counts as: a direction without information must feel the damping, too.
inline constexpr double kLeastDiagonal = 1e-12;

}  // namespace holdfast::detail
