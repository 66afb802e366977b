// An Incremental over many lives. Short under ctest; HOLDFAST_STRESS=full (scripts/stress) lives 10⁵ of them.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
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

TEST(StressIncremental, RandomLivesAgreeWithTheBatch) {
  const char* const chosen = std::getenv("HOLDFAST_STRESS");
  const int lives = chosen != nullptr && std::string(chosen) == "full" ? 100000 : 100;
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

}  // namespace
}  // namespace holdfast::testing
