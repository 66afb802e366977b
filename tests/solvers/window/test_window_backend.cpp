// A window on a back-end object: whatever is a Backend, wrapped ones among them.
#include <gtest/gtest.h>

#include <holdfast/solvers/gnc.hpp>
#include <holdfast/solvers/window/window.hpp>

#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

constexpr Agent A('A');
using Position = HuberMeasurement<Motion2>;

/// A target at rest in the origin, believed 100 m off, seen five times; one sight is an outlier.
Motion2 found_by(Window window) {
  window.add_agent('A', WhiteAcceleration<Motion2>::exact(0.1, 1, Matrix<4, 4>::Identity()), 0.1);
  window.add_state(A(0), 0.0, Motion2(100, 0, 0, 0));
  window.add(Prior<Motion2>::from_sigmas(Motion2(100, 0, 0, 0), {1000, 1, 1000, 1}), {A(0)});
  for (int k = 0; k < 5; ++k) {
    const Vector<2> z = k == 2 ? Vector<2>(-40, 30) : Vector<2>(0.1 * k - 0.2, 0.1);
    window.add(Position::of_position(-z, Vector<2>(0, 0), Matrix<2, 2>::Identity()), {window.at('A', 0.1 * k)}, TruncatedSquares{3.5});
  }
  EXPECT_TRUE(window.step(0.4).summary.usable());
  return window.newest<Motion2>('A');
}

// Truncated squares have no slope 100 m away: descent alone stays there, graduated non-convexity does not.
TEST(WindowBackend, GraduatesARedescendingLossAtEveryStep) {
  EXPECT_GT(found_by(Window(WindowOptions{})).position().norm(), 90);
  EXPECT_LT(found_by(Window({}, gnc(make_backend("irls")))).position().norm(), 0.5);
}

TEST(WindowBackend, KeepsTheOptionsOfTheObject) {
  Options options;
  options.max_iterations = 7;
  const Window window({}, make_backend("nesterov", options));
  EXPECT_EQ(window.options().backend, "nesterov");
  EXPECT_EQ(window.options().solver.max_iterations, 7);
}

TEST(WindowBackend, IsNeverNone) { EXPECT_THROW(Window({}, nullptr), BadOption); }

}  // namespace
}  // namespace holdfast::testing
