// An Incremental over many lives. Short under ctest; HOLDFAST_STRESS=full (scripts/stress): 10⁵ lives, and 10⁶ steps.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <holdfast/factors/range.hpp>
#include <holdfast/testing.hpp>

#include "tests/incremental_life.hpp"

namespace holdfast::testing {
namespace {

struct RandomSource {
  std::mt19937_64 rng;
  int below(int n) { return static_cast<int>(rng() % static_cast<unsigned>(n)); }
  double small() { return uniform(rng, -8, 8); }
  bool empty() const { return false; }
};

bool is_full() {
  const char* const chosen = std::getenv("HOLDFAST_STRESS");
  return chosen != nullptr && std::string(chosen) == "full";
}

TEST(StressIncremental, RandomLivesAgreeWithTheBatch) {
  const int lives = is_full() ? 100000 : 100;
  const std::string path = (std::filesystem::temp_directory_path() / ("holdfast_lives_" + std::to_string(::getpid()))).string();
  int compared = 0, wrong = 0;
  for (int i = 0; i < lives && wrong < 5; ++i) {
    RandomSource source{std::mt19937_64(static_cast<unsigned>(i))};
    const auto say = [&](const std::string& what) {
      ++wrong;
      ADD_FAILURE() << "life " << i << ": " << what;
    };
    IncrementalLife life(source, say, i % 50 == 0 ? path : std::string());  // a save waits for the disk
    life.live(80);
    compared += life.compared();
  }
  std::filesystem::remove(path);
  EXPECT_GT(compared, lives);
}

double resident_megabytes() {
  std::ifstream file("/proc/self/statm");
  double total = 0, resident = 0;
  file >> total >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / 1e6;
}

/// A fixed lag as a policy: poses older than 20 steps are marginalised, points that come into sight now and then are erased again. Numbers
/// of what is gone serve again, of two and three dimensions in turn.
TEST(StressIncremental, AFixedLagIsFlatInMemory) {
  const int steps = is_full() ? 1000000 : 10000, lag = 20;
  constexpr Agent x('x'), L('L');
  const auto pose = [&](int k) { return x(static_cast<unsigned>(k)); };
  const auto point = [&](int k) { return L(static_cast<unsigned>(k)); };
  const Vector<3> sigmas(0.05, 0.05, 0.02);
  const Pose2 step(0.5, 0, 0.05);
  Incremental smoother;
  smoother.insert(pose(0), Pose2());
  smoother.add(Prior<Pose2>::from_sigmas(Pose2(), sigmas), {pose(0)});
  double early = 0;
  for (int k = 1; k <= steps; ++k) {
    smoother.insert(pose(k), smoother.at<Pose2>(pose(k - 1)) * step);
    smoother.add(Between<Pose2>::from_sigmas(step, sigmas), {pose(k - 1), pose(k)});
    smoother.add(Prior<Pose2>::from_sigmas(smoother.at<Pose2>(pose(k - 1)) * step, Vector<3>(1, 1, 1)), {pose(k)});
    if (k % 10 == 0) {
      smoother.insert(point(k), Point2(1, 2));
      smoother.add(Prior<Point2>::from_sigmas(Point2(1, 2), Vector<2>(1, 1)), {point(k)});
      smoother.add(Range<Pose2, Point2>{3, 0.5}, {pose(k), point(k)});
    }
    smoother.update();
    if (k > lag) smoother.marginalize({pose(k - lag)});
    if (k % 10 == 9 && k > 10) smoother.erase(point(k - 9));
    if (k == steps / 10) early = resident_megabytes();
  }
  EXPECT_LE(smoother.size(), static_cast<std::size_t>(lag + 4));
  EXPECT_LT(resident_megabytes(), early + 2);
  EXPECT_LT(smoother.graph().size(), 200u);
}

}  // namespace
}  // namespace holdfast::testing
