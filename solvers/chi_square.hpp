// The χ² distribution: how likely a squared residual is where nothing is wrong, and where to draw the line.
//
//   const double c = std::sqrt(chi_square_quantile(0.99, 3));    // a threshold in sigmas: one true pose in a hundred is beyond it
//   const double p = chi_square_tail(42.0, 3);                   // so often a true measurement of 3 components is as far off
#pragma once

namespace holdfast {

/// P(χ²_d ≥ s) of d >= 1 degrees of freedom; 1 for s <= 0. Closed forms: a sum of d/2 terms, for odd d beside erfc(√(s/2)).
double chi_square_tail(double s, int d);

/// s with P(χ²_d ≤ s) = probability, which is in (0, 1). Throws BadOption.
double chi_square_quantile(double probability, int d);

}  // namespace holdfast
