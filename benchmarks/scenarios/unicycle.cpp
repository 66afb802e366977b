#include <holdfast/benchmarks/scenarios/random.hpp>
#include <holdfast/benchmarks/scenarios/scenario.hpp>
#include <holdfast/factors/huber_measurement.hpp>
#include <holdfast/factors/white_acceleration.hpp>

namespace holdfast::bench {

std::vector<Motion2> unicycle_path(const UnicycleOptions& options, Random& random) {
  std::vector<Motion2> states;
  Vector<2> p = random.uniforms<2>(-50, 50);
  double heading = random.uniform(-kPi, kPi), turn_rate = 0, until = 0;
  for (int k = 0; k < options.states; ++k) {
    const double time = k * options.dt;
    if (time >= until) {
      turn_rate = random.uniform(-0.5, 0.5);
      until = time + random.uniform(2, 6);
    }
    states.emplace_back(p[0], options.speed * std::cos(heading), p[1], options.speed * std::sin(heading));
    const double turn = turn_rate * options.dt;
    const double chord = options.speed * options.dt * (turn == 0 ? 1 : std::sin(turn / 2) / (turn / 2));
    p += chord * Vector<2>(std::cos(heading + turn / 2), std::sin(heading + turn / 2));
    heading += turn;
  }
  return states;
}

Instance unicycle(const UnicycleOptions& options, unsigned seed) {
  Random random(seed);
  constexpr Agent A('A');
  const std::vector<Motion2> truth = unicycle_path(options, random);
  const Vector<2> observer = Vector<2>::Zero();
  const auto motion = WhiteAcceleration<Motion2>::exact(options.dt, 1, Matrix<4, 4>::Identity());
  Instance instance;
  for (int k = 0; k < options.states; ++k) {
    Vector<2> z = observer - truth[k].position() + random.normals<2>(options.sigma);
    if (random.chance(options.outliers)) z += random.uniforms<2>(40, 70);
    instance.graph.add(HuberMeasurement<Motion2>::of_position(z, observer, Matrix<2, 2>::Identity()), {A(k)});
    if (k > 0) instance.graph.add(motion, {A(k - 1), A(k)});
    const Vector<2> measured = observer - z;
    instance.start.insert(A(k), Motion2(measured[0], 0.0, measured[1], 0.0));
    instance.truth.insert(A(k), truth[k]);
  }
  return instance;
}

}  // namespace holdfast::bench
