// A Window over a long life. Short under ctest; HOLDFAST_STRESS=full (scripts/stress) runs as many steps as a robot does in days.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <holdfast/factors/range.hpp>
#include <holdfast/testing.hpp>

#include "tests/window_life.hpp"

namespace holdfast::testing {
namespace {

int count(int in_short, int in_full) {
  const char* chosen = std::getenv("HOLDFAST_STRESS");
  return chosen != nullptr && std::string(chosen) == "full" ? in_full : in_short;
}

struct RandomSource {
  std::mt19937_64 rng;
  int below(int n) { return static_cast<int>(rng() % static_cast<unsigned>(n)); }
  double small() { return uniform(rng, -8, 8); }
  bool empty() const { return false; }
};

TEST(StressWindow, RandomSequencesAgreeWithTheBatch) {
  const int sequences = count(150, 100000);
  const std::string path = (std::filesystem::temp_directory_path() / ("holdfast_stress_" + std::to_string(::getpid()))).string();
  int compared = 0, wrong = 0;
  for (int i = 0; i < sequences && wrong < 5; ++i) {
    RandomSource source{std::mt19937_64(static_cast<unsigned>(i))};
    const auto say = [&](const std::string& what) {
      ++wrong;
      ADD_FAILURE() << "sequence " << i << ": " << what;
    };
    WindowLife life(source, say, i % 50 == 0 ? path : std::string());  // a save waits for the disk
    life.live(80);
    compared += life.compared();
  }
  std::filesystem::remove(path);
  EXPECT_GT(compared, sequences);
  RecordProperty("states_compared", compared);
}

double resident_megabytes() {
  std::ifstream file("/proc/self/statm");
  double total = 0, resident = 0;
  file >> total >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / 1e6;
}

using Motion = WhiteAcceleration<Motion2>;
constexpr double kDt = 0.1;  // [s]
Vector<2> truth(double t) { return {30 * std::sin(0.05 * t), 20 * std::sin(0.08 * t)}; }

/// Two agents, a landmark whose place is known, one second of lag.
Window two_agents() {
  WindowOptions options;
  options.lag = 1;
  Window window(options);
  for (char letter : {'A', 'B'}) {
    window.add_agent(letter, Motion::exact(kDt, 1, 0.5 * Matrix<4, 4>::Identity()), kDt);
    window.add_state(Key(letter, 0), 0.0, Motion2(0, 1.5, 0, 1.6));
    window.add(Prior<Motion2>::from_sigmas(Motion2(0, 1.5, 0, 1.6), {1, 1, 1, 1}), {Key(letter, 0)});
  }
  window.add_beacon(Key('L', 0), Point2(50, -40));
  return window;
}

HuberMeasurement<Motion2> position(const Vector<2>& p) {
  return HuberMeasurement<Motion2>::of_position(-p, Vector<2>(0, 0), 0.04 * Matrix<2, 2>::Identity());
}

TEST(StressWindow, MemoryStaysFlat) {
  const int steps = count(5000, 1000000), settled = steps / 5;
  Window window = two_agents();
  std::mt19937_64 rng(1);
  double before = 0;
  for (int k = 1; k <= steps; ++k) {
    const double t = k * kDt;
    if (k % 7 != 3) window.add(position(truth(t) + random_vector<2>(rng, 0.2)), {window.at('A', t)}, Huber{2});
    window.add(Range<Motion2, Point2>{(truth(t) - Vector<2>(50, -40)).norm(), 0.2}, {window.at('B', t), Key('L', 0)}, Cauchy{2});
    if (k % 5 == 0) window.add(Range<Motion2, Motion2>{0.2, 0.5}, {window.at('A', t), window.at('B', t)}, Huber{2});
    if (k % 11 == 0) window.add(position(truth(t - 0.5)), {window.at('A', t - 0.5)}, Huber{2});  // late
    ASSERT_TRUE(window.step(t).summary.usable()) << "step " << k;
    if (k == settled) before = resident_megabytes();
  }
  EXPECT_LT(resident_megabytes() - before, 1.0) << "megabytes more after " << steps << " steps than after " << settled;
  EXPECT_LT((window.newest<Motion2>('A').position() - truth(steps * kDt)).norm(), 1);
}

// 60 % of what is measured never comes, 60 % of what comes is anywhere within 40 m.
TEST(StressWindow, HoldsUnderOutliersAndLoss) {
  const int steps = count(2000, 100000);
  WindowOptions options;
  options.lag = 2;
  Window window(options);
  window.add_agent('A', Motion::exact(kDt, 1, 0.5 * Matrix<4, 4>::Identity()), kDt);
  window.add_state(Key('A', 0), 0.0, Motion2(0, 1.5, 0, 1.6));
  window.add(Prior<Motion2>::from_sigmas(Motion2(0, 1.5, 0, 1.6), {0.1, 0.1, 0.1, 0.1}), {Key('A', 0)});
  std::mt19937_64 rng(2);
  double squared = 0;
  int scored = 0, failed = 0;
  for (int k = 1; k <= steps; ++k) {
    const double t = k * kDt;
    for (int sensor = 0; sensor < 4; ++sensor) {
      if (uniform(rng, 0, 1) < 0.6) continue;
      const bool outlier = uniform(rng, 0, 1) < 0.6;
      const Vector<2> error = outlier ? Vector<2>(uniform(rng, -40, 40), uniform(rng, -40, 40)) : random_vector<2>(rng, 0.2);
      window.add(position(truth(t) + error), {window.at('A', t)}, Cauchy{1});
    }
    const WindowStep& step = window.step(t);
    failed += !step.summary.usable();
    if (std::abs(window.newest_time() - t) > 1e-9) continue;
    squared += (window.newest<Motion2>('A').position() - truth(t)).squaredNorm();
    ++scored;
  }
  EXPECT_EQ(failed, 0);
  const double rmse = std::sqrt(squared / scored);
  RecordProperty("rmse_millimetres", static_cast<int>(1e3 * rmse));
  EXPECT_LT(rmse, 0.5) << "[m], of measurements of 0.2 m";
}

}  // namespace
}  // namespace holdfast::testing
