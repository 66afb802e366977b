#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <holdfast/factors/missing_distance.hpp>
#include <holdfast/graph/files/internal/text.hpp>
#include <holdfast/solvers/window/window.hpp>

#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

constexpr Agent A('A'), B('B'), L('L');
constexpr double kStep = 0.1;  // [s]

using Motion = WhiteAcceleration<Motion2>;
using Position = HuberMeasurement<Motion2>;

Motion motion(int steps = 1) { return Motion::exact(kStep, steps, 0.7 * Matrix<4, 4>::Identity() + 0.1 * Matrix<4, 4>::Ones()); }
Position position(const Vector<2>& p) { return Position::of_position(-p, Vector<2>(0, 0), Matrix<2, 2>(0.25 * Matrix<2, 2>::Identity())); }
Prior<Motion2> start_prior(const Motion2& x) { return Prior<Motion2>::from_sigmas(x, {1, 0.5, 1, 0.5}); }

WindowOptions exact_options(double lag) {
  WindowOptions options;
  options.lag = lag;
  options.solver = to_the_bottom();
  return options;
}

/// Agent A on its grid from its first state on.
Window tracker(const WindowOptions& options) {
  Window window(options);
  window.add_agent('A', motion(), kStep);
  window.add_state(A(0), 0.0, Motion2(0, 1, 0, 1));
  window.add(start_prior(Motion2(0, 1, 0, 1)), {A(0)});
  return window;
}

Vector<2> truth(double t) { return {t + 0.2 * std::sin(t), t - 0.1 * t * t}; }

void expect_near(const Motion2& a, const Motion2& b, double tolerance, const std::string& what) {
  EXPECT_LT((a.value - b.value).norm(), tolerance * (1 + b.value.norm())) << what;
}
template <int N>
void expect_near(const Matrix<N, N>& a, const Matrix<N, N>& b, double tolerance, const std::string& what) {
  EXPECT_LT((a - b).norm(), tolerance * b.norm()) << what;
}

TEST(Window, AgreesWithTheBatchOfAllMeasurements) {
  std::mt19937_64 rng(1);
  Window window = tracker(exact_options(1.0));
  Graph graph;
  Values values;
  values.insert(A(0), Motion2(0, 1, 0, 1));
  graph.add(start_prior(Motion2(0, 1, 0, 1)), {A(0)});
  for (int k = 1; k <= 60; ++k) {
    const double t = kStep * k;
    const Position z = position(truth(t) + random_vector<2>(rng, 0.5));
    window.add(z, {window.at('A', t)}, Squared{});
    values.insert(A(k), Motion2());
    graph.add(motion(), {A(k - 1), A(k)});
    graph.add(z, {A(k)}, Squared{});
    const WindowStep& step = window.step(t);
    EXPECT_TRUE(step.summary.usable());
    EXPECT_LE(window.states('A').size(), 12u);
  }
  solve("irls", graph, values);
  EXPECT_GT(window.time(window.states('A').front()), 4.8);
  const Marginals mine(window.graph(), window.values()), all(graph, values);
  for (Key key : window.states('A')) {
    expect_near(window.state<Motion2>(key), values.at<Motion2>(key), 1e-9, key.str());
    expect_near<4>(mine.covariance<Motion2>(key), all.covariance<Motion2>(key), 1e-9, key.str());
  }
}

/// m − 1 empty steps between two measured states: one state for each, or one factor over all.
template <class Add>
Window with_gap(bool collapse, int m, const Add& add_agent) {
  WindowOptions options = exact_options(1e6);
  options.collapse = collapse;
  Window window(options);
  add_agent(window);
  window.add_state(A(0), 0.0, Motion2(0, 1, 0, 1));
  window.add(start_prior(Motion2(0, 1, 0, 1)), {A(0)});
  for (int k : {1, 2, 2 + m, 3 + m}) {
    for (int empty = 3; empty < k && k == 2 + m; ++empty) window.at('A', kStep * empty), window.step(kStep * empty);
    window.add(position(truth(kStep * k) + Vector<2>(0.1 * k, -0.2)), {window.at('A', kStep * k)}, Squared{});
    window.step(kStep * k);
  }
  return window;
}

template <class Add>
void expect_collapse_is_exact(const Add& add_agent) {
  for (int m = 1; m <= 50; ++m) {
    const Window one = with_gap(true, m, add_agent), many = with_gap(false, m, add_agent);
    EXPECT_EQ(one.states('A').size(), 5u);
    EXPECT_EQ(many.states('A').size(), 4u + m);
    const Marginals mine(one.graph(), one.values()), all(many.graph(), many.values());
    for (Key key : one.states('A')) {
      Key same;
      for (Key other : many.states('A'))
        if (std::abs(many.time(other) - one.time(key)) < 1e-6) same = other;
      expect_near(one.state<Motion2>(key), many.state<Motion2>(same), 1e-9, std::to_string(m));
      expect_near<4>(mine.covariance<Motion2>(key), all.covariance<Motion2>(same), 1e-9, std::to_string(m));
    }
  }
}

TEST(Window, EmptyStepsAreOneExactFactor) {
  expect_collapse_is_exact([](Window& window) { window.add_agent('A', motion(), kStep); });
}

TEST(Window, EmptyTimesAreOneExactContinuousFactor) {
  expect_collapse_is_exact([](Window& window) { window.add_agent('A', [](double seconds) { return Motion::continuous(seconds, 0.6); }); });
}

TEST(Window, TheOrderOfArrivalDoesNotMatterInsideTheLag) {
  std::mt19937_64 rng(5);
  std::vector<std::pair<int, Vector<2>>> measured;
  for (int k = 1; k <= 20; ++k)
    if (k % 4 != 2) measured.emplace_back(k, truth(kStep * k) + random_vector<2>(rng, 0.5));
  Window in_order = tracker(exact_options(10)), late = tracker(exact_options(10));
  for (const auto& [k, z] : measured) in_order.add(position(z), {in_order.at('A', kStep * k)}, Squared{});
  in_order.step(2);
  std::shuffle(measured.begin(), measured.end(), rng);
  for (const auto& [k, z] : measured) {
    late.add(position(z), {late.at('A', kStep * k)}, Squared{});
    late.step(0);  // a clock that jumps back
    EXPECT_GE(late.last_step().time, kStep * k);
  }
  ASSERT_EQ(in_order.states('A').size(), late.states('A').size());
  const Marginals mine(late.graph(), late.values()), all(in_order.graph(), in_order.values());
  for (std::size_t i = 0; i < in_order.states('A').size(); ++i) {
    const Key a = in_order.states('A')[i], b = late.states('A')[i];
    EXPECT_NEAR(in_order.time(a), late.time(b), 1e-12);
    expect_near(late.state<Motion2>(b), in_order.state<Motion2>(a), 1e-9, a.str());
    expect_near<4>(mine.covariance<Motion2>(b), all.covariance<Motion2>(a), 1e-9, a.str());
  }
}

TEST(Window, RefusesByNameWhatIsTooLateAndGoesOn) {
  Window window = tracker(exact_options(1));
  for (int k = 1; k <= 30; ++k) {
    window.add(position(truth(kStep * k)), {window.at('A', kStep * k)}, Squared{});
    window.step(kStep * k);
  }
  const std::uint64_t structure = window.graph().structure();
  for (const double bad : {0.5, 2.0, -1e300, std::nan(""), 3.05}) EXPECT_THROW(window.at('A', bad), BadTime) << bad;
  EXPECT_THROW(window.at('B', 3.0), BadKey);
  EXPECT_THROW(window.add(position({0, 0}), {A(3)}), BadKey);  // has left
  EXPECT_THROW(window.add(Prior<Pose2>::from_sigmas(Pose2(), {1, 1, 1}), {window.newest_key('A')}), BadType);
  EXPECT_THROW(window.add_state(A(99), 2.95, Motion2()), BadTime);  // no multiple of the step
  EXPECT_THROW(window.add_state(A(99), 3.0, Motion2()), BadTime);   // there is one
  EXPECT_THROW(window.add_landmark(A(99), Point2(0, 0)), BadKey);
  EXPECT_EQ(window.graph().structure(), structure);
  EXPECT_NO_THROW(window.at('A', 2.1));  // just inside
  window.add(position(truth(3.1)), {window.at('A', 3.1)}, Squared{});
  EXPECT_EQ(window.step(3.1).summary.termination, Termination::converged);
  try {
    window.at('A', 0.5);
    FAIL();
  } catch (const BadTime& error) {
    EXPECT_NE(std::string(error.what()).find("lag is 1 s"), std::string::npos) << error.what();
  }
}

// An empty newest state is merged into the motion to the next one: not before that one is accepted.
TEST(Window, ARefusedTimeLeavesTheEmptyStateThatIsThere) {
  Window window = tracker(exact_options(1));
  const Key empty = window.at('A', 0.1);
  const std::uint64_t structure = window.graph().structure();
  EXPECT_THROW(window.at('A', 0.25), BadTime);
  EXPECT_EQ(window.newest_key('A'), empty);
  EXPECT_EQ(window.graph().structure(), structure);
}

TEST(Window, RefusesAClockThatJumpsAhead) {
  WindowOptions options = exact_options(1);
  options.max_gap = 60;
  Window window = tracker(options);
  window.add(position(truth(0.1)), {window.at('A', 0.1)});
  window.step(0.1);
  EXPECT_THROW(window.at('A', 1e9), BadTime);
  EXPECT_THROW(window.step(1e9), BadTime);
  EXPECT_NO_THROW(window.at('A', 50));
}

TEST(Window, AgentsComeAndGo) {
  std::mt19937_64 rng(3);
  Window window = tracker(exact_options(1));
  double expected_A = 0;
  for (int k = 1; k <= 40; ++k) {
    const double t = kStep * k;
    window.add(position(truth(t)), {window.at('A', t)}, Squared{});
    if (k == 10) {
      window.add_agent('B', motion(), kStep);
      window.add_state(B(0), t, Motion2(1, 0, 1, 0));
      window.add(start_prior(Motion2(1, 0, 1, 0)), {B(0)});
    }
    if (k >= 10 && k < 25) {
      const double range = (truth(t) - Vector<2>(1, 1)).norm();
      window.add(Range<Motion2, Motion2>{range, 0.1}, {window.at('A', t), window.at('B', t)}, Huber{2});
    }
    window.step(t);
    if (k == 25) {
      const Marginals before(window.graph(), window.values());
      const Matrix<4, 4> C = before.covariance<Motion2>(window.newest_key('A'));
      window.remove_agent('B');
      expect_near<4>(Marginals(window.graph(), window.values()).covariance<Motion2>(window.newest_key('A')), C, 1e-9, "B has left");
      EXPECT_FALSE(window.has_agent('B'));
    }
    expected_A = t;
  }
  EXPECT_EQ(window.agents(), std::vector<Agent>{'A'});
  EXPECT_NEAR(window.newest_time(), expected_A, 1e-12);
  EXPECT_LT((window.newest<Motion2>('A').position() - truth(4)).norm(), 0.3);
  for (const auto& batch : window.graph().batches())
    for (int i = 0; i < batch->size() * batch->arity(); ++i) EXPECT_EQ(batch->keys(0)[i].agent(), 'A');
}

TEST(Window, AgentsOfOneKindAreApart) {
  const std::string path = ::testing::TempDir() + "holdfast_window_kind";
  constexpr Agent first('r', 1), second('r', 2);
  const auto two = [&](bool with_states) {
    Window window(exact_options(1));
    for (const Agent agent : {first, second}) {
      window.add_agent(agent, motion(), kStep);
      const Motion2 start(agent.number(), 1, 0, 0);
      if (with_states) window.add_state(agent(0), 0.0, start);
      if (with_states) window.add(start_prior(start), {agent(0)});
    }
    return window;
  };
  Window window = two(true);
  for (int k = 1; k <= 5; ++k) {
    const double t = kStep * k;
    window.add(position({1 + t, 0}), {window.at(first, t)}, Squared{});
    EXPECT_EQ(window.newest_key(first), first(static_cast<std::uint64_t>(k)));
    EXPECT_EQ(window.newest_key(second), second(0));
    window.step(t);
  }
  EXPECT_EQ(window.agents(), (std::vector<Agent>{first, second}));
  EXPECT_FALSE(window.has_agent('r'));
  window.add_landmark(Key('r', 0), Point2(1, 1));  // r0 is of agent r
  EXPECT_THROW(window.add_landmark(second(9), Point2(1, 1)), BadKey);
  try {
    window.at(Agent('r', 3), 1);
    ADD_FAILURE();
  } catch (const BadKey& error) {
    EXPECT_NE(std::string(error.what()).find("no agent r3 in"), std::string::npos) << error.what();
  }
  window.save(path);
  Window resumed = two(false);
  resumed.restore(path);
  EXPECT_EQ(resumed.states(first), window.states(first));
  EXPECT_EQ(resumed.states(second), window.states(second));
  resumed.remove_agent(first);
  EXPECT_EQ(resumed.agents(), std::vector<Agent>{second});
  EXPECT_EQ(resumed.newest_key(second), second(0));
  std::filesystem::remove(path);
}

TEST(Window, PosesBringTheirOdometryAndSeeLandmarks) {
  for (const std::string& backend : backend_names()) {
    if (backend != "irls" && backend != "ceres") continue;
    WindowOptions options = exact_options(5);
    options.backend = backend;
    options.covariances = true;
    Window window(options);
    std::mt19937_64 rng(8);
    const Pose2 step(1, 0, 0.1);
    const std::vector<Point2> landmarks{Point2(3, 12), Point2(-8, 4), Point2(5, -3)};
    for (int l = 0; l < 3; ++l) window.add_landmark(L(l), Point2(landmarks[l].value + random_vector<2>(rng, 0.3)));
    Pose2 truth;
    window.add_state(A(0), 0.0, truth);
    window.add(Prior<Pose2>::from_sigmas(truth, {0.01, 0.01, 0.01}), {A(0)});
    for (int k = 1; k <= 100; ++k) {
      truth = truth * step;
      const auto odometry = Between<Pose2>::from_sigmas(step.retract(random_vector<3>(rng, 0.02)), {0.02, 0.02, 0.02});
      window.add_state(A(k), k, A(k - 1), odometry);
      for (int l = 0; l < 3; ++l)
        window.add(Range<Pose2, Point2>{(truth.p - landmarks[l].value).norm() + random_vector<1>(rng, 0.05)[0], 0.05}, {A(k), L(l)},
                   Huber{2});
      const WindowStep& result = window.step(k);
      EXPECT_TRUE(result.summary.usable()) << result.summary.str();
      ASSERT_TRUE(result.marginals.has_value());
      if (k == 100) {
        const Vector<3> error = truth.local(window.newest<Pose2>('A'));
        const Matrix<3, 3> C = result.marginals->covariance<Pose2>(A(100));
        EXPECT_LT(error.dot(C.inverse() * error), 16.3) << backend;  // χ²(3) at 0.999
        EXPECT_LT(error.head<2>().norm(), 0.5);
      }
    }
    EXPECT_EQ(window.states('A').size(), 6u);
    EXPECT_EQ(window.values().size(), 9u);  // the landmarks stay
    window.remove_landmark(L(1));
    EXPECT_EQ(window.values().size(), 8u);
    window.step(100);
  }
}

TEST(Window, DropsOldStatesWithoutAPriorWhereAsked) {
  WindowOptions options = exact_options(1e6);
  options.leaving = WindowOptions::Leaving::drop;
  options.max_states = 14;
  Window window = tracker(options);
  for (int k = 1; k <= 50; ++k) {
    window.add(position(truth(kStep * k)), {window.at('A', kStep * k)});
    window.step(kStep * k);
    if (k > 14) {
      EXPECT_EQ(window.graph().size(), 27u);
    }
  }
  Graph graph;  // the last 14 states and nothing else
  Values values;
  for (int k = 37; k <= 50; ++k) {
    values.insert(A(k), Motion2());
    graph.add(position(truth(kStep * k)), {A(k)});
    if (k > 37) graph.add(motion(), {A(k - 1), A(k)});
  }
  EXPECT_NEAR(window.graph().cost(window.values()), graph.cost(window.values()), 1e-12);
}

TEST(Window, TakesOutWhatIsNotFiniteAndSaysSo) {
  Window window = tracker(exact_options(1));
  for (int k = 1; k <= 20; ++k) {
    window.add(position(truth(kStep * k)), {window.at('A', kStep * k)});
    if (k == 10) window.add(position({1e300, 1e300}), {window.at('A', kStep * k)}, Squared{});
    const WindowStep& step = window.step(kStep * k);
    EXPECT_TRUE(step.summary.usable()) << k << step.summary.str();
    EXPECT_EQ(step.removed.size(), k == 10 ? 1u : 0u);
  }
  EXPECT_LT((window.newest<Motion2>('A').position() - truth(2)).norm(), 0.3);
}

TEST(Window, GoesOnWhereItWasMovedTo) {
  Window window = tracker(exact_options(1)), stays = tracker(exact_options(1));
  for (int k = 1; k <= 20; ++k) {
    for (Window* one : {&window, &stays}) {
      one->add(position(truth(kStep * k)), {one->at('A', kStep * k)});
      one->step(kStep * k);
    }
    if (k != 10) continue;
    Window other(std::move(window));
    window = std::move(other);
  }
  EXPECT_TRUE(same_bits(window.values(), stays.values()));
}

TEST(Window, SaysWhereNothingIsFree) {
  Window window(exact_options(1));
  window.add_beacon(L(0), Point2(0, 0));
  window.add_beacon(L(1), Point2(3, 4));
  window.add(Range<Point2, Point2>{6, 0.5}, {L(0), L(1)}, Squared{});
  const WindowStep& step = window.step(0);
  EXPECT_TRUE(step.summary.usable());
  EXPECT_STREQ(step.summary.rule, "nothing is free");
  EXPECT_EQ(window.state<Point2>(L(1)).value, Vector<2>(3, 4));
}

TEST(Window, AnAgentWithoutAMotionHasTheStatesItWasGiven) {
  Window window(exact_options(1));
  window.add_state(B(0), 0.0, Pose2(1, 2, 0));
  window.add(Prior<Pose2>::from_sigmas(Pose2(1, 2, 0), {1, 1, 1}), {B(0)});
  EXPECT_EQ(window.at('B', 0.0), B(0));
  try {
    window.at('B', 0.1);
    ADD_FAILURE() << "a state was made from nothing";
  } catch (const BadTime& error) {
    EXPECT_NE(std::string(error.what()).find("no motion to make one from"), std::string::npos) << error.what();
  }
  EXPECT_EQ(window.states('B'), std::vector<Key>{B(0)});
}

TEST(Window, ReportsWhatItsLossesBelieve) {
  WindowOptions options = exact_options(1);
  options.report = true;
  Window window = tracker(options);
  for (int k = 1; k <= 12; ++k) {
    const Vector<2> outlier(k == 12 ? 30 : 0, 0);
    window.add(position(truth(kStep * k) + outlier), {window.at('A', kStep * k)});
    window.step(kStep * k);
  }
  int outliers = 0;
  for (const MeasurementReport& one : window.last_step().report) {
    if (one.factor != "HuberMeasurement") continue;
    const bool is_last = std::abs(one.time - 1.2) < 1e-9;
    EXPECT_EQ(one.verdict, is_last ? MeasurementReport::Verdict::outlier : MeasurementReport::Verdict::inlier) << one.keys[0];
    ASSERT_EQ(one.raw.size(), 2u);
    EXPECT_NEAR(one.raw[0], 0.5 * one.whitened[0], 1e-12);  // sigma 0.5 m
    if (is_last) {
      EXPECT_NEAR(one.weight, 2 / std::abs(one.whitened[0]), 1e-12);
    }
    outliers += one.verdict == MeasurementReport::Verdict::outlier;
  }
  EXPECT_EQ(outliers, 1);
}

// ---- files

std::string path_of(const std::string& name) { return (std::filesystem::temp_directory_path() / ("holdfast_window_" + name)).string(); }

/// Two agents with ranges between them and to a landmark, from step k on.
void drive(Window& window, int from, int to) {
  for (int k = from; k < to; ++k) {
    std::mt19937_64 rng(k);
    const double t = kStep * k;
    if (k % 5 != 3) window.add(position(truth(t) + random_vector<2>(rng, 0.5)), {window.at('A', t)});
    if (k % 3 != 1)
      window.add(Range<Motion2, Point2>{(truth(t) - Vector<2>(3, 1)).norm() + random_vector<1>(rng, 0.1)[0], 0.1},
                 {window.at('B', t), L(0)}, Cauchy{2});
    if (k % 4 == 0)
      window.add(Range<Motion2, Motion2>{std::abs(random_vector<1>(rng, 0.2)[0]), 0.2}, {window.at('A', t), window.at('B', t)}, Huber{2});
    if (k % 6 == 0) window.add(position(truth(t - 0.3)), {window.at('A', t - 0.3)});  // late
    window.step(t);
  }
}

Window two_agents(bool with_states) {
  WindowOptions options;
  options.lag = 1;
  Window window(options);
  window.add_agent('A', motion(), kStep);
  window.add_agent('B', [](double seconds) { return Motion::continuous(seconds, 0.6); });
  if (!with_states) return window;
  window.add_landmark(L(0), Point2(2.8, 1.1));
  for (const Key key : {A(0), B(0)}) {
    window.add_state(key, 0.0, Motion2(0, 1, 0, 1));
    window.add(start_prior(Motion2(0, 1, 0, 1)), {key});
  }
  return window;
}

TEST(Window, ResumesWithTheSameBits) {
  const std::string path = path_of("resume");
  Window whole = two_agents(true), first = two_agents(true);
  drive(whole, 1, 80);
  drive(first, 1, 37);
  first.save(path, "at 37");
  Window second = two_agents(false);
  EXPECT_EQ(second.restore(path), "at 37");
  EXPECT_TRUE(same_bits(first.values(), second.values()));
  drive(second, 37, 80);
  EXPECT_TRUE(same_bits(whole.values(), second.values()));
  EXPECT_EQ(whole.states('A'), second.states('A'));
  std::filesystem::remove(path);
}

TEST(Window, NamesFactorsAfterARestoreAsBeforeTheSave) {
  const std::string path = path_of("ids");
  Window first = two_agents(true);
  drive(first, 1, 20);
  const FactorId taken_back = first.add(position({9, 9}), {first.newest_key('A')});
  const FactorId kept = first.add(position({1, 2}), {first.newest_key('A')});
  first.remove(taken_back);
  first.save(path);
  Window second = two_agents(false);
  second.restore(path);
  EXPECT_FALSE(second.graph().contains(taken_back));
  EXPECT_EQ(second.graph().at<Position>(kept).known, first.graph().at<Position>(kept).known);
  const FactorId next = first.add(position({3, 4}), {first.newest_key('A')}), same = second.add(position({3, 4}), {second.newest_key('A')});
  EXPECT_EQ(next.number, same.number);
  EXPECT_EQ(next.generation, same.generation);
  std::filesystem::remove(path);
}

TEST(Window, KeepsAnAgentThatJoinedAfterTheSave) {
  const std::string path = path_of("joined");
  Window first = tracker(exact_options(1.0));
  first.save(path);
  Window second = two_agents(true);
  second.restore(path);
  EXPECT_EQ(second.agents(), (std::vector<Agent>{'A', 'B'}));
  EXPECT_TRUE(second.states('B').empty());
  second.add_state(B(0), 0.0, Motion2(0, 1, 0, 1));
  EXPECT_EQ(second.at('B', 0.25).agent(), 'B');  // its motion is still there
  std::filesystem::remove(path);
}

TEST(Window, AStateThatIsRefusedLeavesNoTrace) {
  Window window = tracker(exact_options(1.0));
  window.step(0.0);
  const std::size_t factors = window.graph().size();
  Motion bad = motion();
  bad.sqrt_information.setConstant(NAN);
  EXPECT_THROW(window.add_state(B(0), 0.1, A(0), bad), BadNumber);                  // of an agent that is not there yet
  EXPECT_THROW(window.add_state(A(7), 0.1 * kStep, Motion2(0, 1, 0, 1)), BadTime);  // off the motion's grid
  EXPECT_THROW(window.add_state(A(7), 0.1 * kStep, A(0), motion()), BadTime);
  EXPECT_EQ(window.agents(), std::vector<Agent>{'A'});
  EXPECT_EQ(window.states('A').size(), 1u);
  EXPECT_EQ(window.graph().size(), factors);
  EXPECT_EQ(window.values().size(), 1u);
}

void expect_refused(Window& window, const std::string& path, const std::string& bytes, const std::string& why) {
  std::ofstream(path, std::ios::binary) << bytes;
  const Values before = window.values();
  try {
    window.restore(path);
    ADD_FAILURE() << why;
  } catch (const BadFile& error) {
    EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find(path), std::string::npos) << error.what();
  }
  EXPECT_TRUE(same_bits(before, window.values()));
}

TEST(Window, RefusesFilesThatAreTornForeignOrOfAnotherRobot) {
  const std::string path = path_of("refused");
  Window window = two_agents(true);
  drive(window, 1, 20);
  window.save(path);
  const std::string good = io::read_file(path);
  for (const std::size_t size : {std::size_t{1}, std::size_t{20}, good.size() / 2, good.size() - 1})
    expect_refused(window, path, good.substr(0, size), size < 16 ? "no file of a holdfast window" : size < 28 ? "end" : "torn");
  expect_refused(window, path, good + "x", "torn");
  expect_refused(window, path, "VERTEX_SE2 0 A0 0 0 0\n", "no file of a holdfast window");
  std::string damaged = good;
  damaged[good.size() / 2] ^= 1;
  expect_refused(window, path, damaged, "checksum");
  std::string newer = good;
  newer[16] = 9;
  expect_refused(window, path, newer, "version 9");
  newer[16] = 2;
  expect_refused(window, path, newer, "version 2, and this program reads version 4; start a new window");
  WindowOptions options;
  Window other(options);
  other.add_agent('A', [](double seconds) { return WhiteAcceleration<Motion3>::continuous(seconds, 1); });
  expect_refused(other, path, good, "agent A moves by");
  std::filesystem::remove(path);
  EXPECT_THROW(window.restore(path), BadFile);
}

// ---- options

TEST(Window, ChecksItsOptions) {
  const auto refuses = [](auto change) {
    WindowOptions options;
    change(options);
    EXPECT_THROW(Window{options}, BadOption);
  };
  refuses([](WindowOptions& o) { o.lag = 0; });
  refuses([](WindowOptions& o) { o.lag = NAN; });
  refuses([](WindowOptions& o) { o.max_states = -1; });
  refuses([](WindowOptions& o) { o.deadline = 0; });
  refuses([](WindowOptions& o) { o.max_gap = -1; });
  refuses([](WindowOptions& o) { o.backend = "nobody"; });
}

}  // namespace
}  // namespace holdfast::testing
