// A point that only ranges know, until they say where it is. From a short or straight path a range fits two places, mirror images of one
// another: both are kept as hypotheses, and the point is in no window, until the measurements tell them apart.
#pragma once

#include <holdfast/graph/variables.hpp>
#include <optional>
#include <vector>

namespace holdfast::program {

/// One range to the point, and where the other end was.
struct Sight {
  std::uint64_t number = 0;  ///< of its line
  Vector<3> from = Vector<3>::Zero();
  double distance = 0, sigma = 1;  ///< [m]
};

/// What is known of the point beside the ranges: a place, and how far it may be from there [m].
struct Guess {
  Vector<3> place = Vector<3>::Zero();
  double sigma = 1;
};

/// Where the point is, or nothing as long as that is not settled. The place is the best of several descents of
///   Σ ½ρ(((‖x − from‖ − distance) / sigma)²) + ½ ‖x − guess‖² / guess.sigma²      ρ: Cauchy, 2 sigmas
/// that begin on circles (in space: spheres) round three of the sights. It is settled where every other minimum costs at least
/// `kMargin` more, a likelihood e^6 times smaller, and where its own standard deviation is at most a quarter of the least distance.
/// Sigmas that are too small, and poses that have drifted, are noticed by the residuals: costs are divided by the square of their scale.
/// dim: 2 in the plane (the third coordinate stays 0) or 3.
std::optional<Vector<3>> located(const std::vector<Sight>& sights, const std::optional<Guess>& guess, int dim);

}  // namespace holdfast::program
