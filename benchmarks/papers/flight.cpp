#include <holdfast/benchmarks/papers/flight.hpp>
#include <holdfast/benchmarks/scenarios/random.hpp>

namespace holdfast::bench {
namespace {

/// So far along the figure, which begins in the origin, along x, and turns left first.
Motion2 on_the_figure(double length) {
  const double circle = 2 * kPi * kFlightRadius;
  length = std::fmod(length, 2 * circle);
  if (length < 0) length += 2 * circle;
  const double side = length < circle ? 1 : -1;  // of the centre
  const double angle = length / kFlightRadius;   // whole turns do not matter
  const double v = kFlightSpeed;
  return {kFlightRadius * std::sin(angle), v * std::cos(angle), side * kFlightRadius * (1 - std::cos(angle)), side * v * std::sin(angle)};
}

/// Multivariate: one scale for both axes.
Vector<2> student(double nu, Random& random) {
  const double scale = random.student_scale(nu);
  return scale * random.normals<2>(1);
}

Vector<2> noise(const FlightOptions& options, Random& random) {
  if (options.mixture) return random.chance(options.alpha) ? student(options.nu, random) : random.normals<2>(1);
  const Vector<2> t = student(random.uniform(25, 50), random);
  return options.alpha * t + (1 - options.alpha) * random.normals<2>(1);
}

}  // namespace

Flight flight(const FlightOptions& options, unsigned seed) {
  constexpr double kSpacing = 0.5;  // [m]
  Random random(seed);
  const double begin = random.uniform(0, 4 * kPi * kFlightRadius);
  Flight flight{options, {}, {}};
  for (int follower = 0; follower < kFollowers; ++follower) {
    flight.truth.emplace_back();
    flight.gps.emplace_back();
    for (int k = 0; k < options.steps; ++k) {
      flight.truth.back().push_back(on_the_figure(begin + kFlightSpeed * kFlightStep * k - kSpacing * (follower + 1)));
      flight.gps.back().push_back(flight.truth.back().back().position() + noise(options, random));
    }
  }
  return flight;
}

}  // namespace holdfast::bench
