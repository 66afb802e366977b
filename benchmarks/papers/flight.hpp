// Paper B's scenario: a leader flies a figure of eight, two circles of 20 m that touch in the origin, at 0.4 m/s; eight followers fly the
// same way, 0.5 m behind each other. Each has a GPS, every 0.032 s, with "hybrid" noise on each axis:
//
//   printed, eq. (1)    v = α t_ν + (1 − α) g              ν ~ U(25, 50) a sample: a weighted sum, hardly different from a Gaussian
//   mixture             v = t_ν in a share α of the samples, else g; ν = 3: what the text describes
#pragma once

#include <holdfast/graph/variables/kinematic.hpp>
#include <vector>

namespace holdfast::bench {

struct FlightOptions {
  double alpha = 0.1;
  bool mixture = false;
  double nu = 3;     ///< of the mixture
  int steps = 9818;  ///< half a figure of eight, from anywhere on it
};

constexpr int kFollowers = 8;
constexpr double kFlightStep = 0.032;                     // [s]
constexpr double kFlightSpeed = 0.4, kFlightRadius = 20;  // [m/s], [m]

struct Flight {
  FlightOptions options;
  std::vector<std::vector<Motion2>> truth;  ///< by follower, then step
  std::vector<std::vector<Vector<2>>> gps;  ///< [m]
};
Flight flight(const FlightOptions& options, unsigned seed);

}  // namespace holdfast::bench
