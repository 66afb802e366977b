// A target followed online by a window of two seconds: noisy positions at 10 Hz, one in five an outlier of 20 m or lost, some late.
#include <holdfast/factors/huber_measurement.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/white_acceleration.hpp>
#include <holdfast/solvers/window/window.hpp>
#include <iostream>
#include <random>

using namespace holdfast;

int main() {
  constexpr Agent A('A');
  constexpr double dt = 0.1;
  WindowOptions options;
  options.lag = 2;           // [s]
  options.backend = "irls";  // or any other
  options.covariances = true;
  Window window(options);
  window.add_agent('A', WhiteAcceleration<Motion2>::exact(dt, 1, Matrix<4, 4>::Identity()), dt);
  window.add_state(A(0), 0.0, Motion2(0, 1, 0, 0));
  window.add(Prior<Motion2>::from_sigmas(Motion2(0, 1, 0, 0), {1, 1, 1, 1}), {A(0)});

  std::mt19937_64 rng(1);
  std::normal_distribution<double> normal(0, 0.3);
  const auto measured = [&](double t, double error) {
    const Vector<2> z(t + normal(rng) + error, std::sin(t) + normal(rng));
    return HuberMeasurement<Motion2>::of_position(-z, Vector<2>(0, 0), 0.09 * Matrix<2, 2>::Identity());
  };
  double worst = 0;
  for (int k = 1; k <= 200; ++k) {
    const double t = k * dt;
    if (k % 10 != 3) window.add(measured(t, k % 10 == 7 ? 20 : 0), {window.at('A', t)}, TruncatedSquares{4});
    if (k % 20 == 9) window.add(measured(t - 0.5, 0), {window.at('A', t - 0.5)}, TruncatedSquares{4});  // late
    const WindowStep& step = window.step(t);
    if (!step.summary.usable()) return 1;
    const Vector<2> p = window.newest<Motion2>('A').position();
    if (k > 20)
      worst = std::max(worst, (p - Vector<2>(window.time(window.newest_key('A')), std::sin(window.time(window.newest_key('A'))))).norm());
    if (k % 50 == 0)
      std::cout << "t = " << t << " s: " << p.transpose() << ", sigma "
                << std::sqrt(step.marginals->covariance<Motion2>(window.newest_key('A'))(0, 0)) << " m, " << window.states('A').size()
                << " states, " << 1e6 * (step.seconds.add + step.seconds.solve + step.seconds.marginalize) << " us\n";
  }
  std::cout << "worst error " << worst << " m\n";
  return worst < 1.0 ? 0 : 1;
}
