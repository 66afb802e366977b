#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <holdfast/factors/missing_distance.hpp>
#include <holdfast/solvers/window/schedule.hpp>

#include "tests/graph/files/helpers.hpp"
#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

using ::testing::HasSubstr;

constexpr Agent A('A'), L('L');
using To = Range<Motion2, Point2>;
using Missing = MissingDistance<Motion2, Point2>;

/// Agent A moves along x at 1 m/s and measures its distance to the beacon L0 each second.
struct Robot {
  Window window;
  Schedule schedule{window};
  StreamId<To> ranges;

  explicit Robot(bool silent = false, double lag = 8) : window(options(lag)) {
    window.add_agent('A', WhiteAcceleration<Motion2>::exact(1, 1, 0.1 * Matrix<4, 4>::Identity()), 1.0);
    window.add_state(A(0), 0.0, Motion2(0, 1, 0, 0));
    window.add(Prior<Motion2>::from_sigmas(Motion2(0, 1, 0, 0), {0.1, 0.1, 0.1, 0.1}), {A(0)});
    window.add_beacon(L(0), Point2(-3, 4));
    ranges = silent ? schedule.expect<To>('A', L(0), 1.0, 1.0) : schedule.expect<To>('A', L(0), 1.0, 1.0, [](const To& last, int m) {
      return Missing{last.distance, last.sigma, 0.5 * std::sqrt(m)};
    });
  }
  static WindowOptions options(double lag) {
    WindowOptions options;
    options.lag = lag;
    options.report = true;
    options.solver = to_the_bottom();
    return options;
  }
  static To range(double t, double error = 0) { return {std::hypot(t + 3, 4) + error, 0.1}; }
  void receive(double t, double error = 0) { schedule.receive(ranges, t, range(t, error), Cauchy{2}); }
  void step(double t) {
    schedule.close(t);
    schedule.judge(window.step(t).report);
  }
  const Stream& stream() const { return schedule.stream(ranges); }
  std::vector<Missing> missing() const {
    std::vector<Missing> all;
    window.graph().for_each_batch<Missing>(
        [&](const Batch<Missing>& batch) { all.insert(all.end(), batch.factors().begin(), batch.factors().end()); });
    return all;
  }
  Arrival arrival(int number) const {
    for (const Stream::Entry& entry : stream().entries())
      if (entry.number == number) return entry.arrival;
    ADD_FAILURE() << number;
    return Arrival::dropped;
  }
};

TEST(Schedule, KnowsWhatBecameOfEachMeasurement) {
  Robot robot;
  for (int t = 1; t <= 7; ++t) {
    if (t == 5) robot.schedule.lose(robot.ranges, t, Arrival::out_of_range);
    if (t != 3 && t != 5) robot.receive(t, t == 6 ? 40 : 0);
    robot.step(t);
  }
  const Arrival expected[] = {Arrival::received,     Arrival::received, Arrival::dropped, Arrival::received,
                              Arrival::out_of_range, Arrival::rejected, Arrival::received};
  for (int n = 0; n < 7; ++n) EXPECT_EQ(robot.arrival(n), expected[n]) << n << ' ' << to_string(robot.arrival(n));
  EXPECT_EQ(robot.stream().count(Arrival::received), 4u);
  EXPECT_EQ(robot.stream().count(Arrival::dropped), 1u);
}

TEST(Schedule, ARangeThatDidNotArriveBoundsTheDistanceLessAndLess) {
  Robot robot;
  robot.receive(1);
  for (int t = 1; t <= 5; ++t) robot.step(t);
  const std::vector<Missing> missing = robot.missing();
  ASSERT_EQ(missing.size(), 4u);
  for (int m = 1; m <= 4; ++m) {
    EXPECT_EQ(missing[m - 1].d_prev, Robot::range(1).distance);
    EXPECT_NEAR(missing[m - 1].rho, 0.5 * std::sqrt(m), 1e-12);
  }
  EXPECT_EQ(robot.window.states('A').size(), 6u);
}

TEST(Schedule, NothingIsBoundBeforeTheFirstRangeOrWithoutAFactorForIt) {
  Robot never;
  for (int t = 1; t <= 5; ++t) never.step(t);
  EXPECT_TRUE(never.missing().empty());
  Robot silent(true);
  silent.receive(1);
  for (int t = 1; t <= 5; ++t) silent.step(t);
  silent.receive(6);
  silent.step(6);
  EXPECT_EQ(silent.window.states('A').size(), 3u);  // 0, 1 and 6: five steps in one motion
  EXPECT_EQ(silent.stream().count(Arrival::dropped), 4u);
}

TEST(Schedule, TheLastArrivalBoundsThoseAfterItAlsoWhenItHasLeftTheWindow) {
  Robot robot(false, 4);
  robot.receive(1);
  for (int t = 1; t <= 12; ++t) robot.step(t);
  ASSERT_GT(robot.stream().entries().front().number, 0);  // number 0, which came at 1 s, is forgotten
  const std::vector<Missing> missing = robot.missing();
  ASSERT_FALSE(missing.empty());
  double widest = 0;
  for (const Missing& one : missing) {
    EXPECT_EQ(one.d_prev, Robot::range(1).distance);
    widest = std::max(widest, one.rho);
  }
  EXPECT_NEAR(widest, 0.5 * std::sqrt(11), 1e-12);  // the one at 12 s: eleven after the last that came
}

TEST(Schedule, ALateRangeTakesThePlaceOfItsBound) {
  Robot robot, in_time;
  for (int t = 1; t <= 6; ++t) {
    if (t < 3 || t == 6) robot.receive(t);
    if (t < 4 || t == 6) in_time.receive(t);
    robot.step(t);
    in_time.step(t);
  }
  EXPECT_EQ(robot.missing().size(), 3u);
  robot.receive(3);  // after all
  robot.step(6);
  EXPECT_EQ(robot.arrival(2), Arrival::received);
  ASSERT_EQ(robot.missing().size(), 2u);
  EXPECT_EQ(robot.missing()[0].d_prev, Robot::range(3).distance);
  EXPECT_NEAR(robot.window.graph().cost(robot.window.values()), in_time.window.graph().cost(in_time.window.values()), 1e-9);
  EXPECT_LT((robot.window.newest<Motion2>('A').value - in_time.window.newest<Motion2>('A').value).norm(), 1e-6);
}

TEST(Schedule, WhatTheWindowRefusesChangesNothing) {
  Robot robot(false, 4);
  for (int t = 1; t <= 12; ++t) {
    if (t != 3 && t != 10) robot.receive(t);
    robot.step(t);
  }
  const std::size_t dropped = robot.stream().count(Arrival::dropped);
  EXPECT_THROW(robot.receive(3), BadTime);
  EXPECT_THROW(robot.receive(-5), BadTime);
  Robot another;
  EXPECT_THROW(robot.schedule.receive(another.ranges, 12, Robot::range(12)), BadKey);
  EXPECT_THROW(robot.schedule.receive(StreamId<To>(), 12, Robot::range(12)), BadKey);
  EXPECT_THROW(robot.schedule.lose(another.ranges, 12, Arrival::dropped), BadKey);
  EXPECT_EQ(robot.stream().count(Arrival::dropped), dropped);
  robot.receive(10);
  EXPECT_EQ(robot.stream().count(Arrival::dropped), dropped - 1);
  EXPECT_LE(robot.stream().entries().size(), 7u);  // the past is forgotten
}

template <class Measurement, class = void>
struct TakesFromAStreamOfRanges : std::false_type {};
template <class Measurement>
struct TakesFromAStreamOfRanges<
    Measurement, std::void_t<decltype(std::declval<Schedule&>().receive(std::declval<StreamId<To>>(), 0.0, std::declval<Measurement>()))>>
    : std::true_type {};

TEST(Schedule, AMeasurementOfAnotherTypeDoesNotCompile) {
  EXPECT_TRUE(TakesFromAStreamOfRanges<To>::value);
  EXPECT_FALSE((TakesFromAStreamOfRanges<Range<Motion2, Motion2>>::value));
  EXPECT_FALSE(TakesFromAStreamOfRanges<Missing>::value);
}

TEST(Schedule, RefusesTimesThatItCannotHaveExpected) {
  Robot robot(false, 4);
  for (int t = 1; t <= 12; ++t) {
    robot.receive(t);
    robot.step(t);
  }
  const auto refusal = [&](auto act) -> std::string {
    try {
      act();
    } catch (const BadTime& error) {
      return error.what();
    } catch (const BadOption& error) {
      return error.what();
    }
    return "";
  };
  const auto lose = [&](double t, Arrival why) { return refusal([&] { robot.schedule.lose(robot.ranges, t, why); }); };
  EXPECT_THAT(lose(2, Arrival::dropped), HasSubstr("due at 2 s has left the window"));
  EXPECT_THAT(lose(5e6, Arrival::dropped), HasSubstr("repair the clock"));
  EXPECT_THAT(lose(12, Arrival::rejected), HasSubstr("'rejected' is no loss"));
  EXPECT_EQ(robot.stream().count(Arrival::dropped), 0u);
  EXPECT_EQ(robot.stream().count(Arrival::received), 12u);
  EXPECT_EQ(robot.arrival(11), Arrival::received);
}

TEST(Schedule, BoundsWhatWasSkippedWhenTheNextIsHeardOf) {
  Robot robot;
  robot.receive(1);
  robot.step(1);
  robot.receive(5);  // nobody closed 2, 3 and 4
  ASSERT_EQ(robot.missing().size(), 3u);
  EXPECT_EQ(robot.missing()[2].d_prev, Robot::range(1).distance);
  EXPECT_EQ(robot.stream().count(Arrival::dropped), 3u);
}

TEST(Schedule, AnAgentIsBoundWhileItIsThere) {
  Robot robot;
  const StreamId<To> later = robot.schedule.expect<To>('B', L(0), 1.0, 1.0, [](const To& last, int) {
    return Missing{last.distance, last.sigma, 1};
  });
  for (int t = 1; t <= 3; ++t) robot.step(t);
  EXPECT_EQ(robot.schedule.stream(later).count(Arrival::dropped), 3u);
  EXPECT_TRUE(robot.missing().empty());
  robot.window.add_agent('B', WhiteAcceleration<Motion2>::exact(1, 1, 0.1 * Matrix<4, 4>::Identity()), 1.0);
  robot.window.add_state(Key('B', 0), 4.0, Motion2(0, 0, 0, 0));
  robot.schedule.receive(later, 4, To{5, 0.1});
  for (int t = 4; t <= 6; ++t) robot.step(t);
  EXPECT_EQ(robot.missing().size(), 2u);
  EXPECT_EQ(robot.schedule.stream(later).count(Arrival::received), 1u);
  robot.window.remove_agent('B');
  for (int t = 7; t <= 9; ++t) robot.step(t);
  EXPECT_TRUE(robot.missing().empty());
  EXPECT_EQ(robot.schedule.stream(later).count(Arrival::dropped), 8u);
}

TEST(Schedule, TellsAgentsOfOneKindApart) {
  Robot robot;
  constexpr Agent first('r', 1), second('r', 2);
  for (const Agent agent : {first, second}) {
    robot.window.add_agent(agent, WhiteAcceleration<Motion2>::exact(1, 1, 0.1 * Matrix<4, 4>::Identity()), 1.0);
    robot.window.add_state(agent(0), 0.0, Motion2(0, 0, 0, 0));
  }
  const auto stream = robot.schedule.expect<To>(second, L(0), 1.0, 1.0);
  robot.schedule.receive(stream, 1, To{5, 0.1});
  EXPECT_EQ(robot.window.newest_key(first), first(0));
  EXPECT_EQ(robot.window.newest_key(second), second(1));
}

TEST(Schedule, IsSavedWithItsWindow) {
  const std::string path = ::testing::TempDir() + "holdfast_schedule";
  Robot whole, first;
  const auto drive = [](Robot& robot, int from, int to) {
    for (int t = from; t < to; ++t) {
      if (t % 3 != 0) robot.receive(t, 0.05 * (t % 5));
      if (t % 7 == 2 && t > 4) robot.receive(t - 2);
      robot.step(t);
    }
  };
  drive(whole, 1, 40);
  drive(first, 1, 20);
  first.window.save(path, first.schedule.save());
  Robot second;
  second.schedule.restore(second.window.restore(path));
  drive(second, 20, 40);
  EXPECT_TRUE(same_bits(whole.window.values(), second.window.values()));
  for (Arrival arrival : {Arrival::received, Arrival::rejected, Arrival::dropped})
    EXPECT_EQ(whole.stream().count(arrival), second.stream().count(arrival));
  Window other;
  Schedule none(other);
  EXPECT_THROW(none.restore(first.schedule.save()), BadFile);
  Schedule of_others(first.window);
  of_others.expect<Missing>('A', L(0), 1.0, 1.0);
  testing_io::expect_message<BadFile>([&] { of_others.restore(first.schedule.save()); },
                                      {"{distance double, sigma double}", "d_prev double"});
  Robot without_its_window;
  EXPECT_THROW(without_its_window.schedule.restore(first.schedule.save()), BadFile);
  std::remove(path.c_str());
}

}  // namespace
}  // namespace holdfast::testing
