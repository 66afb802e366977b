// What a step's deadline leaves for the solve, and where a step's time went.
#include <gtest/gtest.h>

#include <chrono>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/white_acceleration.hpp>
#include <holdfast/solvers/table.hpp>
#include <holdfast/solvers/window/window.hpp>
#include <thread>

namespace holdfast {
namespace {

constexpr Agent A('A');
constexpr double kSlow = 0.02;  // [s]

/// Ends after kSlow, whatever happens, and notes what time it was given.
class Noting final : public Backend {
 public:
  using Backend::Backend;
  std::string name() const override { return "noting"; }
  static double time_limit;

 protected:
  Summary minimize(const Graph&, Values&) override {
    time_limit = options.time_limit;
    std::this_thread::sleep_for(std::chrono::duration<double>(kSlow));
    Summary summary;
    summary.termination = Termination::time_limit;
    return summary;
  }
};
double Noting::time_limit = 0;

/// A window with one agent whose motion takes kSlow to make.
struct Slow {
  Window window;

  explicit Slow(double deadline, double time_limit = std::numeric_limits<double>::infinity()) : window(options(deadline, time_limit)) {
    window.add_agent('A', [](double seconds) {
      std::this_thread::sleep_for(std::chrono::duration<double>(kSlow));
      return WhiteAcceleration<Motion2>::continuous(seconds, 1);
    });
    window.add_state(A(0), 0.0, Motion2(0, 1, 0, 0));
    window.add(Prior<Motion2>::from_sigmas(Motion2(0, 1, 0, 0), {1, 1, 1, 1}), {A(0)});
    window.at('A', 1.0);
  }
  static WindowOptions options(double deadline, double time_limit) {
    register_backend("noting", [](const Options& options) { return std::make_unique<Noting>(options); });
    WindowOptions options;
    options.backend = "noting";
    options.deadline = deadline;
    options.solver.time_limit = time_limit;
    return options;
  }
};

TEST(Deadline, LeavesTheSolveWhatAddingHasNotTaken) {
  Slow slow(1000);
  const WindowStep& step = slow.window.step(1.0);
  EXPECT_GE(step.seconds.add, kSlow);
  EXPECT_EQ(Noting::time_limit, 1000 - step.seconds.add);
  EXPECT_TRUE(step.deadline_kept);
}

TEST(WindowStep, SaysWhereTheTimeWent) {
  Slow slow(1000);
  const WindowStep& step = slow.window.step(1.0);
  EXPECT_GE(step.seconds.add, kSlow);
  EXPECT_GE(step.seconds.solve, kSlow);
  EXPECT_GE(step.summary.seconds, kSlow);
  EXPECT_LE(step.summary.seconds, step.seconds.solve);
  EXPECT_EQ(step.seconds.covariances, 0);  // not asked for
  EXPECT_EQ(step.seconds.report, 0);
  EXPECT_EQ(step.seconds.total(), step.seconds.add + step.seconds.solve + step.seconds.marginalize);
}

TEST(Deadline, OfEachStepIsItsOwn) {
  Slow slow(1000);
  slow.window.step(1.0);
  const WindowStep& second = slow.window.step(1.0);  // nothing was added
  EXPECT_EQ(Noting::time_limit, 1000 - second.seconds.add);
  EXPECT_LT(second.seconds.add, kSlow);
}

TEST(Deadline, ThatHasPassedLeavesTimeForOneIteration) {
  Slow slow(1e-6);
  const WindowStep& step = slow.window.step(1.0);
  EXPECT_DOUBLE_EQ(Noting::time_limit, 1e-8);  // a hundredth of it
  EXPECT_FALSE(step.deadline_kept);
}

TEST(Deadline, DoesNotLengthenTheSolversOwnLimit) {
  Slow slow(1000, 5);
  slow.window.step(1.0);
  EXPECT_EQ(Noting::time_limit, 5);
}

TEST(Deadline, LeavesTheSolversOwnLimitAloneWhereThereIsNone) {
  Slow slow(std::numeric_limits<double>::infinity(), 5);
  EXPECT_TRUE(slow.window.step(1.0).deadline_kept);
  EXPECT_EQ(Noting::time_limit, 5);
}

}  // namespace
}  // namespace holdfast
