// Rules that several factors state about their numbers, beside those of graph/require.hpp.
#pragma once

#include <holdfast/graph/require.hpp>

namespace holdfast {

/// A concentration, weight or density: positive, with a cure of its own.
inline void require_positive_number(const char* what, double value, const char* cure) {
  if (!(std::isfinite(value) && value > 0)) fail<BadNumber>(what, " = ", value, " must be finite and > 0; ", cure);
}

/// The concentration of a von Mises(–Fisher) distribution.
inline void require_concentration(const char* what, double kappa) {
  require_positive_number(what, kappa, "give 1/sigma^2 of a direction error of sigma [rad]");
}

inline void require_count(const char* what, int value) {
  if (value < 1) fail<BadNumber>(what, " = ", value, " must be >= 1; give the number of steps");
}

/// A measured direction must have length 1 to 1e-6.
template <int N>
void require_unit(const char* what, const Vector<N>& u) {
  require_finite(what, u);
  if (!(std::abs(u.norm() - 1) <= 1e-6))
    fail<BadNumber>(what, " = [", u.transpose(), "] has norm ", u.norm(), " and must be a unit vector to 1e-6; divide it by its norm");
}

}  // namespace holdfast
