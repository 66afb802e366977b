// Paper A's scenario: one or two UAVs geolocate a ground target that drives as a unicycle (scenario.hpp), every 0.05 s.
//
//   z = p_target + N(0, σ²) + outlier,   an outlier U(low, high) m on both axes, or Student's t on top; some measurements are missing
#pragma once

#include <holdfast/benchmarks/scenarios/scenario.hpp>

namespace holdfast::bench {

/// What one UAV's camera does.
struct SensorOptions {
  double outliers = 0;         ///< probability
  double low = 40, high = 70;  ///< of an outlier on each axis [m]
  double missing = 0;          ///< probability
  double student_nu = 0;       ///< > 0: every axis gets Student's t with so many degrees of freedom on top [m]
};

struct PursuitOptions {
  int steps = 400;
  double dt = 0.05;           ///< [s]
  double speed = 20;          ///< of the target [m/s]
  double sigma = 5;           ///< of every camera, each axis [m]
  bool random_signs = false;  ///< each axis of each outlier to either side; else always positive
  std::vector<SensorOptions> sensors{1};
};
/// Steps of 0.05 s: σ = 1 m at 10 m/s, and σ = 5 m at 20 m/s.
PursuitOptions gentle();
PursuitOptions fast();

/// One camera's measurement of one step.
struct Sighting {
  bool received = false;
  bool outlier = false;
  Vector<2> z = Vector<2>::Zero();  ///< where the target seems to be [m]
};

struct Pursuit {
  PursuitOptions options;
  std::vector<Motion2> truth;                    ///< by step
  std::vector<std::vector<Sighting>> sightings;  ///< by step, then camera; the first step is always received
};
Pursuit pursuit(const PursuitOptions& options, unsigned seed);
/// The same target and the same missing measurements, but no outliers and no t noise.
Pursuit without_outliers(const PursuitOptions& options, unsigned seed);

/// Where an estimator thinks the target was, by step.
using Positions = std::vector<Vector<2>>;
/// √ mean ‖estimate − truth‖² over the steps first … last − 1 [m].
double rmse(const Pursuit& pursuit, const Positions& positions, int first, int last);

}  // namespace holdfast::bench
