// A vehicle tracked by positions that may all be wrong at once: the window notices that it follows outliers, says so, and finds its way
// back. 1 m of noise at 20 Hz, one in five measurements 50 m off to the same side, one in five lost; after 20 s the vehicle jumps by 200 m.
#include <holdfast/factors/huber_measurement.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/white_acceleration.hpp>
#include <holdfast/solvers/window/window.hpp>
#include <iostream>
#include <random>

using namespace holdfast;

int main() {
  WindowOptions options;
  options.max_states = 30;
  Window window(options);
  window.add_agent('A', Steering<Motion2>{});  // it steers and hardly changes its speed
  window.keep_lock('A', {}, [](const Motion2& seen) { return Prior<Motion2>::from_sigmas(seen, {1000, 20, 1000, 20}); });

  std::mt19937_64 rng(1);
  std::normal_distribution<double> noise(0, 1);
  double error = 0;
  for (int k = 0; k < 800; ++k) {
    const double t = 0.05 * k;
    const Vector<2> p(10 * t + (t < 20 ? 0 : 200), 20 * std::sin(0.3 * t));
    const Vector<2> z = p + Vector<2>(noise(rng), noise(rng)) + (rng() % 5 == 0 ? Vector<2>(50, 50) : Vector<2>(0, 0));
    if (k > 0 && rng() % 5 == 0) continue;  // lost
    const auto seen = HuberMeasurement<Motion2>::of_position(-z, Vector<2>(0, 0), Matrix<2, 2>::Identity());
    window.add(seen, {window.at('A', t)}, TruncatedSquares{3.5});
    const WindowStep& step = window.step(t);
    if (!step.reacquired.empty()) std::cout << "t = " << t << " s: lost, and found again\n";
    error = (window.state_at<Motion2>('A', t).position() - p).norm();
  }
  std::cout << "last error " << error << " m\n";
  return error < 2 ? 0 : 1;
}
