// A window in its steady state allocates nothing, and a million steps leave the memory as it was.
#include <gtest/gtest.h>

#include <fstream>
#include <holdfast/solvers/window/window.hpp>

#include "tests/counting_new.hpp"
#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

constexpr Agent A('A');
using Motion = WhiteAcceleration<Motion2>;
using Position = HuberMeasurement<Motion2>;

/// Paper A's window of 15 states.
Window fifteen_states(WindowOptions::Leaving leaving) {
  WindowOptions options;
  options.max_states = 14;
  options.leaving = leaving;
  options.solver.cost_tolerance = 1e-4;
  Window window(options);
  window.add_agent('A', Motion::exact(0.05, 1, Matrix<4, 4>::Identity()), 0.05, per_component(Huber{2}));
  window.add_state(A(0), 0.0, Motion2());
  window.add(Prior<Motion2>::from_sigmas(Motion2(), {10, 10, 10, 10}), {A(0)});
  return window;
}

void step(Window& window, int k, std::mt19937_64& rng) {
  const double t = 0.05 * k;
  const Vector<2> outlier = k % 5 == 0 ? Vector<2>(50, 60) : Vector<2>(0, 0);
  const Vector<2> z = Vector<2>(3 * std::sin(0.3 * t), -0.5 * t) + random_vector<2>(rng) + outlier;
  if (k % 7 != 3) window.add(Position::of_position(-z, Vector<2>(0, 0), Matrix<2, 2>::Identity()), {window.at('A', t)});
  if (k % 7 == 3) window.at('A', t);  // nothing arrived: the state is merged into a longer motion when the next one comes
  if (k % 11 == 4) window.add(Position::of_position(-z, Vector<2>(0, 0), Matrix<2, 2>::Identity()), {window.at('A', t - 0.1)});  // late
  window.step(t);
}

void expect_none(WindowOptions::Leaving leaving) {
  Window window = fifteen_states(leaving);
  std::mt19937_64 rng(1);
  int k = 1;
  for (; k < 400; ++k) step(window, k, rng);
  allocations = 0;
  for (; k < 800; ++k) {
    const Position made =
        Position::of_position(Vector<2>(0, 0), Vector<2>(0, 0), Matrix<2, 2>::Identity());  // allocates, outside the count
    const double t = 0.05 * k;
    counting = true;
    window.add(made, {window.at('A', t)});
    const WindowStep& result = window.step(t);
    counting = false;
    EXPECT_TRUE(result.summary.usable());
  }
  EXPECT_EQ(allocations, 0);
}

TEST(WindowAllocation, NoneInASteadyStateThatMarginalises) { expect_none(WindowOptions::Leaving::marginalize); }
TEST(WindowAllocation, NoneInASteadyStateThatDrops) { expect_none(WindowOptions::Leaving::drop); }

/// Of this process [bytes].
double resident() {
  std::ifstream file("/proc/self/statm");
  double pages = 0, in_memory = 0;
  file >> pages >> in_memory;
  return in_memory * 4096;
}

TEST(WindowAllocation, TheMemoryOfManyStepsIsThatOfFew) {
  Window window = fifteen_states(WindowOptions::Leaving::marginalize);
  std::mt19937_64 rng(2);
  int k = 1;
  for (; k < 2000; ++k) step(window, k, rng);
  const double before = resident();
  for (; k < 12000; ++k) step(window, k, rng);
  EXPECT_LT(resident() - before, 1e6);
}

}  // namespace
}  // namespace holdfast::testing
