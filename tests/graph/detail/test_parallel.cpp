#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <fstream>
#include <holdfast/graph/detail/parallel.hpp>
#include <numeric>
#include <stdexcept>
#include <string>

namespace holdfast {
namespace {

TEST(ThreadPool, RunsEveryTaskOnce) {
  for (const int threads : {1, 2, 3, 8}) {
    ThreadPool pool(threads);
    EXPECT_EQ(pool.threads(), threads);
    for (const int tasks : {0, 1, 2, 7, 1000}) {
      std::vector<std::atomic<int>> runs(tasks);
      pool.run(tasks, [&](int i) { ++runs[i]; });
      for (const auto& count : runs) ASSERT_EQ(count, 1) << threads << " threads, " << tasks << " tasks";
    }
  }
}

TEST(ThreadPool, IsReadyAgainAfterEveryRun) {
  ThreadPool pool(3);
  std::vector<long> parts(20);
  for (int round = 0; round < 2000; ++round) {
    pool.run(20, [&](int i) { parts[i] = round + i; });
    ASSERT_EQ(std::accumulate(parts.begin(), parts.end(), 0L), 20L * round + 190);
  }
}

TEST(ThreadPool, HandsOnTheFirstExceptionAndStaysUsable) {
  for (const int threads : {1, 4}) {
    ThreadPool pool(threads);
    std::atomic<int> done{0};
    const auto task = [&](int i) {
      if (i == 5) throw std::runtime_error("task 5");
      ++done;
    };
    try {
      pool.run(50, task);
      ADD_FAILURE();
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(std::string(error.what()), "task 5");
    }
    EXPECT_EQ(done, 49);  // the others are not left half done
    EXPECT_NO_THROW(pool.run(50, [](int) {}));
  }
}

TEST(ParallelFor, IsAPlainLoopWithoutAPool) {
  std::vector<int> order;
  parallel_for(nullptr, 5, [&](int i) { order.push_back(i); });
  EXPECT_EQ(order, (std::vector<int>{0, 1, 2, 3, 4}));
  ThreadPool alone(1);
  parallel_for(&alone, 2, [&](int i) { order.push_back(i); });
  EXPECT_EQ(order.size(), 7u);
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // they reserve more address space than any limit leaves
TEST(ThreadPool, MakesDoWithTheThreadsThatTheSystemGives) {
  rlimit before{};
  ::getrlimit(RLIMIT_AS, &before);
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const rlimit few_stacks{pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)) + (std::uint64_t{100} << 20), before.rlim_max};
  ::setrlimit(RLIMIT_AS, &few_stacks);
  ThreadPool pool(500);
  ::setrlimit(RLIMIT_AS, &before);
  EXPECT_LT(pool.threads(), 500);
  std::atomic<int> sum{0};
  pool.run(101, [&](int i) { sum += i; });
  EXPECT_EQ(sum, 5050);
}
#endif

TEST(ParallelFor, UsesThePool) {
  ThreadPool pool(2);
  std::atomic<int> sum{0};
  parallel_for(&pool, 101, [&](int i) { sum += i; });
  EXPECT_EQ(sum, 5050);
}

}  // namespace
}  // namespace holdfast
