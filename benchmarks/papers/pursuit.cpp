#include <holdfast/benchmarks/papers/pursuit.hpp>
#include <holdfast/benchmarks/scenarios/random.hpp>

namespace holdfast::bench {
namespace {

Sighting seen(const Vector<2>& p, const SensorOptions& sensor, const PursuitOptions& options, bool clean, Random& random) {
  // Every number is drawn whether it is used or not: clean and soiled runs of a seed share target, noise and gaps.
  Sighting sighting;
  sighting.z = p + random.normals<2>(options.sigma);
  Vector<2> gross = random.uniforms<2>(sensor.low, sensor.high);
  for (int axis = 0; axis < 2; ++axis)
    if (random.chance(0.5) && options.random_signs) gross[axis] = -gross[axis];
  const bool outlier = random.chance(sensor.outliers);
  sighting.received = !random.chance(sensor.missing);
  if (clean) return sighting;
  sighting.outlier = outlier;
  if (outlier) sighting.z += gross;
  return sighting;
}

Pursuit made(const PursuitOptions& options, unsigned seed, bool clean) {
  Random random(seed), heavy(seed + (1ull << 32));
  UnicycleOptions unicycle;
  unicycle.states = options.steps;
  unicycle.dt = options.dt;
  unicycle.speed = options.speed;
  Pursuit pursuit{options, unicycle_path(unicycle, random), {}};
  for (int k = 0; k < options.steps; ++k) {
    pursuit.sightings.emplace_back();
    for (const SensorOptions& sensor : options.sensors) {
      Sighting sighting = seen(pursuit.truth[k].position(), sensor, options, clean, random);
      if (k == 0) sighting.received = true;
      if (sensor.student_nu > 0 && !clean)
        for (int axis = 0; axis < 2; ++axis) sighting.z[axis] += heavy.student_scale(sensor.student_nu) * heavy.normal();
      pursuit.sightings.back().push_back(sighting);
    }
  }
  return pursuit;
}

}  // namespace

PursuitOptions gentle() {
  PursuitOptions options;
  options.speed = 10;
  options.sigma = 1;
  return options;
}
PursuitOptions fast() { return {}; }

Pursuit pursuit(const PursuitOptions& options, unsigned seed) { return made(options, seed, false); }
Pursuit without_outliers(const PursuitOptions& options, unsigned seed) { return made(options, seed, true); }

double rmse(const Pursuit& pursuit, const Positions& positions, int first, int last) {
  double sum = 0;
  for (int k = first; k < last; ++k) sum += (positions[k] - pursuit.truth[k].position()).squaredNorm();
  return std::sqrt(sum / (last - first));
}

}  // namespace holdfast::bench
