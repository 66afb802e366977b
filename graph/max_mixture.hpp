// A loss for measurements that are now and then much worse, by a known factor: the better of two Gaussians (Olson and Agarwal, "Inference
// on networks of mixtures for robust robot mapping", IJRR 32, 2013), here N(0, 1) with probability 1 − ε and N(0, width²) with ε = 0.1,
// in sigmas of a block of d components:
//
//   ρ(s) = min(s, s / width² + 2 d ln width + 2 ln((1 − ε)/ε))
//
//   graph.add(range, keys, MaxMixture{10});              // a tenth of the ranges has ten times the sigma
//   graph.add(range, keys, one_sided(MaxMixture{10}));   // without line of sight: only too long ranges are of the wide kind
//
// An outlier keeps the weight 1/width²: unlike a redescending loss it never lets go of anything, unlike Huber its pull at the knee drops.
// For files and command lines "max_mixture:10" after register_loss<MaxMixture>(), which the program `holdfast` calls.
#pragma once

#include <algorithm>
#include <cmath>
#include <holdfast/graph/error.hpp>
#include <holdfast/graph/loss.hpp>

namespace holdfast {

struct MaxMixture {
  double width = 10;  ///< > 1 [sigmas]: of the wide Gaussian

  static constexpr double kShare = 0.1;  ///< ε

  Rho rho(double s, int d) const {
    const double slope = 1 / (width * width), wide = slope * s + offset(d);
    return s <= wide ? Rho{s, 1, 0} : Rho{wide, slope, 0};
  }
  /// Huber from where the wide one takes over.
  Huber relaxed() const { return {std::sqrt(offset(1) / (1 - 1 / (width * width)))}; }
  void validate() const {
    if (!(std::isfinite(width) && width > 1)) fail<BadNumber>("MaxMixture.width = ", width, " must be finite and > 1; 10 is usual");
  }
  static const char* name() { return "max_mixture"; }
  double scale() const { return width; }

 private:
  double offset(int d) const { return 2 * d * std::log(width) + 2 * std::log((1 - kShare) / kShare); }
};

}  // namespace holdfast
