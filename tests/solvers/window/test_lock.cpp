// Window: an agent that keeps lock, motion that depends on the state, states between states, and arrival costs that are let go.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <holdfast/factors/range.hpp>
#include <holdfast/solvers/window/window.hpp>

#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

constexpr Agent A('A'), B('B');
constexpr double kStep = 0.1;  // [s]
constexpr int kJump = 60, kSteps = 140;
using Motion = WhiteAcceleration<Motion2>;
using Position = HuberMeasurement<Motion2>;

Prior<Motion2> nothing_known(const Motion2& seen) { return Prior<Motion2>::from_sigmas(seen, {1000, 20, 1000, 20}); }
Position position(const Vector<2>& z) { return Position::of_position(-z, Vector<2>(0, 0), Matrix<2, 2>::Identity()); }

WindowOptions twenty_states(const std::string& backend = "irls") {
  WindowOptions options;
  options.max_states = 20;
  options.backend = backend;
  options.solver = to_the_bottom();
  return options;
}

Window locked(const std::string& backend = "irls", const LockOptions& lock = {}, double q = 10) {
  Window window(twenty_states(backend));
  window.add_agent(A, [q](double seconds) { return Motion::continuous(seconds, q); });
  window.keep_lock(A, lock, nothing_known);
  return window;
}

/// At 5 m/s along x; from the step kJump on it is 100 m further on, as if all before had been outliers.
Vector<2> seen(int k, std::mt19937_64& rng) { return Vector<2>(5 * kStep * k + (k < kJump ? 0 : 100), 0) + random_vector<2>(rng); }

void measure(Window& window, int k, std::mt19937_64& rng, const Loss& loss = TruncatedSquares{3.5}) {
  window.add(position(seen(k, rng)), {window.at(A, kStep * k)}, loss);
}

TEST(Lock, IsLostNoticedSaidAndFoundAgain) {
  std::mt19937_64 rng(1);
  Window window = locked();
  int noticed = -1, found = -1;
  for (int k = 0; k < kSteps; ++k) {
    measure(window, k, rng);
    const WindowStep& step = window.step(kStep * k);
    if (noticed < 0 && !step.lost.empty()) noticed = k;
    if (found < 0 && !step.reacquired.empty()) found = k;
    EXPECT_TRUE(step.reacquired.empty() || step.lost == std::vector<Agent>{A});
  }
  EXPECT_GE(noticed, kJump + 4);  // more than half of 8
  EXPECT_LE(noticed, kJump + 5);
  EXPECT_GE(found, noticed);
  EXPECT_LE(found, kJump + LockOptions().memory + LockOptions().patience);  // by then the memory holds nothing else
  EXPECT_TRUE(window.last_step().lost.empty());
  EXPECT_LT((window.newest<Motion2>(A).position() - Vector<2>(5 * kStep * (kSteps - 1) + 100, 0)).norm(), 2);
  EXPECT_LE(window.states(A).size(), 20u);
}

// The same by ranges to beacons alone: these are held where they are while the agent is looked for.
TEST(Lock, IsFoundAgainByRangesToBeacons) {
  std::mt19937_64 rng(1);
  Window window = locked();
  const std::vector<Vector<2>> beacons = {{0, 0}, {200, 0}, {0, 200}};
  for (int b = 0; b < 3; ++b) window.add_beacon(Key('L', b), Point2(beacons[b]));
  bool lost = false, found = false;
  for (int k = 0; k < kSteps; ++k) {
    const Vector<2> place = seen(k, rng) + Vector<2>(20, 30);
    for (int b = 0; b < 3; ++b)
      window.add(Range<Motion2, Point2>{(place - beacons[b]).norm(), 1}, {window.at(A, kStep * k), Key('L', b)}, TruncatedSquares{3.5});
    const WindowStep& step = window.step(kStep * k);
    lost = lost || !step.lost.empty();
    found = found || !step.reacquired.empty();
  }
  EXPECT_TRUE(lost && found);
  EXPECT_LT((window.newest<Motion2>(A).position() - Vector<2>(5 * kStep * (kSteps - 1) + 120, 30)).norm(), 2);
}

TEST(Window, TakesAFactorOfAnotherGraph) {
  Graph other;
  const FactorId near = other.add(position({3, 4}), {A(0)}, Huber{2}, 3.0);
  const FactorId nowhere = other.add(position({3, 4}), {A(7)});
  const FactorId wrong = other.add(Prior<Point2>::from_sigmas(Point2(0, 0), {1, 1}), {A(0)});
  Window window = locked();
  window.add_state(A(0), 0, Motion2(1, 0, 1, 0));
  const FactorId id = window.add_from(other, near);
  EXPECT_EQ(window.graph().residual(id, window.values()), other.residual(near, window.values()));
  Graph alone;
  alone.add(position({3, 4}), {A(0)}, Huber{2}, 3.0);
  EXPECT_EQ(window.graph().cost(window.values()), alone.cost(window.values()));
  EXPECT_THROW(window.add_from(other, nowhere), BadKey);
  EXPECT_THROW(window.add_from(other, wrong), BadType);
  EXPECT_THROW(window.add_from(other, FactorId{}), BadKey);
  EXPECT_EQ(window.graph().size(), 1u);
}

// What the same window does without: the arrival cost holds it, and every measurement is an outlier, for ever.
TEST(Lock, IsLostForEverWhereNobodyWatches) {
  std::mt19937_64 rng(1);
  Window window(twenty_states());
  window.add_agent(A, [](double seconds) { return Motion::continuous(seconds, 10); });
  window.add_state(A(0), 0.0, Motion2());
  window.add(nothing_known(Motion2()), {A(0)});
  for (int k = 0; k < kSteps; ++k) {
    measure(window, k, rng);
    window.step(kStep * k);
  }
  EXPECT_GT((window.newest<Motion2>(A).position() - Vector<2>(5 * kStep * (kSteps - 1) + 100, 0)).norm(), 50);
}

// Measurements that are in the window keep their names, and the window its keys.
TEST(Lock, LeavesNamesAsTheyWere) {
  std::mt19937_64 rng(1);
  Window window = locked();
  std::vector<std::pair<Key, FactorId>> all;
  for (int k = 0; k < kSteps; ++k) {
    const Key state = window.at(A, kStep * k);
    all.emplace_back(state, window.add(position(seen(k, rng)), {state}, TruncatedSquares{3.5}));
    const bool reacquired = !window.step(kStep * k).reacquired.empty();
    if (!reacquired) continue;
    const std::vector<Key> states = window.states(A);
    for (const auto& [key, id] : all) EXPECT_EQ(window.graph().contains(id), std::count(states.begin(), states.end(), key) == 1) << key;
    EXPECT_EQ(states.back(), state);
    return;
  }
  FAIL() << "it never lost lock";
}

// What a re-acquisition leaves in the window is what the whole memory says: nothing is lost by leaving the older half out. A target this
// steady cannot have been at both ends of the jump, so that it is clear which measurements are outliers.
TEST(Lock, GoesOnFromAllThatItRemembers) {
  constexpr double kSteady = 0.01;  // [m²/s³]
  std::mt19937_64 rng(3);
  Window window = locked("irls", {}, kSteady);
  std::vector<Vector<2>> z;
  for (int k = 0; k < kSteps; ++k) {
    z.push_back(seen(k, rng));
    window.add(position(z.back()), {window.at(A, kStep * k)}, TruncatedSquares{3.5});
    if (window.step(kStep * k).reacquired.empty()) continue;
    Graph graph;
    Values values;
    const int first = std::max(0, k - 60);
    for (int i = first; i <= k; ++i) {
      values.insert(A(i), Motion2(5 * kStep * i + 100, 5, 0, 0));
      graph.add(position(z[i]), {A(i)}, TruncatedSquares{3.5});
      if (i > first) graph.add(Motion::continuous(kStep, kSteady), {A(i - 1), A(i)});
    }
    graph.add(nothing_known(Motion2(z[first][0], 0, z[first][1], 0)), {A(first)});
    make_backend("irls", to_the_bottom())->solve(graph, values);
    EXPECT_LT((window.newest<Motion2>(A).value - values.at<Motion2>(A(k)).value).norm(), 1e-3);  // σ = 1; the prior has another mean
    const Matrix<4, 4> P = Marginals(graph, values).covariance<Motion2>(A(k));
    EXPECT_LT((window.covariance_at<Motion2>(A, kStep * k) - P).norm(), 1e-6 * P.norm());
    return;
  }
  FAIL() << "it never lost lock";
}

TEST(Lock, GivesTheSameAnswersFromCeresAndIrls) {
  const std::vector<std::string> names = backend_names();
  if (std::count(names.begin(), names.end(), "ceres") == 0) GTEST_SKIP() << "this build has no Ceres";
  std::mt19937_64 rng(4), again(4);
  Window irls = locked("irls"), ceres = locked("ceres");
  int reacquired = 0;
  for (int k = 0; k < kSteps; ++k) {
    measure(irls, k, rng);
    measure(ceres, k, again);
    reacquired += !irls.step(kStep * k).reacquired.empty();
    ceres.step(kStep * k);
    EXPECT_EQ(irls.last_step().reacquired, ceres.last_step().reacquired) << k;
    EXPECT_LT((irls.newest<Motion2>(A).value - ceres.newest<Motion2>(A).value).norm(), 1e-5) << k;
  }
  EXPECT_GE(reacquired, 1);
}

// A good measurement far from its prediction: descent from the prediction leaves it without weight, and the window would go straight on.
TEST(Lock, TriesANewMeasurementFromWhereItIsRight) {
  for (const bool keeps_lock : {false, true}) {
    Window window(twenty_states());
    window.add_agent(A, [](double seconds) { return Motion::continuous(seconds, 2000); });
    if (keeps_lock) window.keep_lock(A, {}, nothing_known);
    window.add_state(A(0), 0.0, Motion2());
    window.add(Prior<Motion2>::from_sigmas(Motion2(), {0.1, 0.1, 0.1, 0.1}), {A(0)});
    window.add(position({5, 0}), {window.at(A, 0.5)}, TruncatedSquares{3.5});  // σ of the prediction: 9 m
    window.step(0.5);
    if (keeps_lock)
      EXPECT_NEAR(window.newest<Motion2>(A).value[0], 5, 0.1);
    else
      EXPECT_NEAR(window.newest<Motion2>(A).value[0], 0, 1e-9);
  }
}

TEST(Lock, StartsWhereItIsSeen) {
  Window window = locked();
  window.add(position({30, -40}), {window.at(A, 2.0)}, TruncatedSquares{3.5});
  window.step(2.0);
  EXPECT_LT((window.state_at<Motion2>(A, 2.0).value - Motion2(30, 0, -40, 0).value).norm(), 1e-6);
}

// What another agent knows stays when this one is forgotten: B is known through a measurement to A alone.
TEST(Lock, ForgetsNobodyElse) {
  std::mt19937_64 rng(1);
  Window window = locked();
  window.add_agent(B, [](double seconds) { return Motion::continuous(seconds, 1e-6); });
  bool reacquired = false;
  Matrix<4, 4> before;
  for (int k = 0; k < kSteps && !reacquired; ++k) {
    measure(window, k, rng);
    if (k == 0) {
      window.add_state(B(0), 0.0, Motion2(0, 0, 7, 0));
      window.add(Prior<Motion2>::from_sigmas(Motion2(0, 0, 7, 0), {1e3, 1e-3, 1e3, 1e-3}), {B(0)});
    }
    if (k == 1) window.add(PositionStep<Motion2, Motion2>{0.5}, {window.at(A, kStep), window.at(B, kStep)});
    if (k > 1) window.at(B, kStep * k);
    before = k > 0 ? window.covariance_at<Motion2>(B, window.time(window.newest_key(B))) : Matrix<4, 4>::Zero();
    reacquired = !window.step(kStep * k).reacquired.empty();
  }
  ASSERT_TRUE(reacquired);
  const Matrix<4, 4> after = window.covariance_at<Motion2>(B, window.time(window.newest_key(B)));
  EXPECT_LT(std::sqrt(before(0, 0)), 2);
  EXPECT_LT(std::sqrt(after(0, 0)), 4);
}

// Saved between two steps, about the jump and before it: the window that goes on from the file says the same to the last bit.
TEST(Lock, RemembersThroughASave) {
  const std::string path = ::testing::TempDir() + "lock_window";
  for (const int saved : {0, 40, kJump + 3, kJump + 20}) {
    std::mt19937_64 rng(1), again(1);
    Window first = locked(), second = locked();
    int reacquired = 0;
    for (int k = 0; k < kSteps; ++k) {
      measure(first, k, rng);
      const Vector<2> z = seen(k, again);
      if (k == saved) {  // its measurement is in, and no step has seen it
        first.save(path);
        second.restore(path);
      } else if (k > saved) {
        second.add(position(z), {second.at(A, kStep * k)}, TruncatedSquares{3.5});
      }
      first.step(kStep * k);
      if (k < saved) continue;
      second.step(kStep * k);
      ASSERT_EQ(first.last_step().lost, second.last_step().lost) << saved << " " << k;
      ASSERT_EQ(first.last_step().reacquired, second.last_step().reacquired) << saved << " " << k;
      ASSERT_EQ(first.newest<Motion2>(A).value, second.newest<Motion2>(A).value) << saved << " " << k;
      reacquired += !second.last_step().reacquired.empty();
    }
    EXPECT_GE(reacquired, 1) << saved;
  }
}

TEST(Lock, IsNotRestoredWhereItIsNotKept) {
  const std::string path = ::testing::TempDir() + "lock_window";
  Window keeps = locked(), does_not(twenty_states());
  does_not.add_agent(A, [](double seconds) { return Motion::continuous(seconds, 10); });
  does_not.add_state(A(0), 0.0, Motion2());
  keeps.save(path);
  EXPECT_THROW(does_not.restore(path), BadFile);
  EXPECT_EQ(does_not.states(A).size(), 1u);
  does_not.save(path);
  EXPECT_THROW(keeps.restore(path), BadFile);
}

TEST(Lock, ChecksItsOptionsAndItsAgent) {
  const auto refused = [](void (*change)(LockOptions&)) {
    LockOptions options;
    change(options);
    EXPECT_THROW(options.validate(), BadOption);
  };
  refused([](LockOptions& o) { o.memory = 1; });
  refused([](LockOptions& o) { o.recent = 0; });
  refused([](LockOptions& o) { o.rejected = 0; });
  refused([](LockOptions& o) { o.patience = 0; });
  refused([](LockOptions& o) { o.settled = -1; });
  Window window;
  EXPECT_THROW(window.keep_lock(A, {}, nothing_known), BadKey);
  window.add_state(B(0), 0.0, Motion2());
  EXPECT_THROW(window.keep_lock(B, {}, nothing_known), BadOption);
  window.add_agent(A, Steering<Motion3>{});
  EXPECT_THROW(window.keep_lock(A, {}, nothing_known), BadType);
}

// ---- motion that depends on the state it leads from

TEST(StateDependentMotion, IsToldTheEstimateOnceTheStateIsKnown) {
  std::vector<std::optional<double>> told;
  Window window(twenty_states());
  window.add_agent(A, [&told](double seconds, const Motion2* from) {
    told.push_back(from == nullptr ? std::nullopt : std::optional<double>(from->value[0]));
    return Motion::continuous(seconds, 10);
  });
  LockOptions lock;
  lock.settled = 3;
  window.keep_lock(A, lock, nothing_known);
  std::mt19937_64 rng(2);
  for (int k = 0; k < 3; ++k) {
    measure(window, k, rng);
    window.step(kStep * k);
  }
  for (const auto& x : told) EXPECT_FALSE(x.has_value());
  window.at(A, kStep * 3);
  window.step(kStep * 3);
  const double newest = window.newest<Motion2>(A).value[0];
  told.clear();
  window.at(A, kStep * 4);
  ASSERT_FALSE(told.empty());
  for (const auto& x : told) EXPECT_TRUE(x.has_value());
  EXPECT_LT(std::abs(*told.back() - newest), 2);
}

// ---- states between states

TEST(StateAt, IsTheCubicBetweenTwoStatesAndTheMotionBeyond) {
  Window window(twenty_states());
  window.add_agent(A, [](double seconds) { return Motion::continuous(seconds, 3); });
  window.add_state(A(0), 0.0, Motion2(1, 2, 0, -1));
  window.add(Prior<Motion2>::from_sigmas(Motion2(1, 2, 0, -1), {1, 1, 1, 1}), {A(0)});
  window.add(position({7, 1}), {window.at(A, 2.0)}, Squared{});
  window.step(2.0);
  const Motion2 from = window.state<Motion2>(A(0)), to = window.newest<Motion2>(A);
  for (const double t : {0.5, 1.0, 1.7})
    for (int axis = 0; axis < 2; ++axis) {  // Hermite's cubic, s = t/T
      const double s = t / 2, p = from.value[2 * axis], v = 2 * from.value[2 * axis + 1], q = to.value[2 * axis],
                   w = 2 * to.value[2 * axis + 1];
      const double expected =
          (1 + 2 * s) * (1 - s) * (1 - s) * p + s * (1 - s) * (1 - s) * v + s * s * (3 - 2 * s) * q + s * s * (s - 1) * w;
      EXPECT_NEAR(window.state_at<Motion2>(A, t).value[2 * axis], expected, 1e-9);
    }
  EXPECT_EQ(window.state_at<Motion2>(A, 2.0).value, to.value);
  EXPECT_LT((window.state_at<Motion2>(A, 2.4).value - transition<Motion2>(0.4) * to.value).norm(), 1e-12);
  EXPECT_THROW(window.state_at<Motion2>(A, -0.1), BadTime);
  EXPECT_THROW(window.state_at<Point2>(A, 1.0), BadType);
}

TEST(StateAt, CarriesTheCovarianceAsAKalmanStepDoes) {
  Window window(twenty_states());
  window.add_agent(A, [](double seconds) { return Motion::continuous(seconds, 3); });
  window.add_state(A(0), 0.0, Motion2());
  window.add(Prior<Motion2>::from_sigmas(Motion2(), {1, 2, 3, 4}), {A(0)});
  window.step(0);
  const Matrix<4, 4> P = Vector<4>(1, 4, 9, 16).asDiagonal(), F = transition<Motion2>(0.4), W = Motion::continuous(0.4, 3).sqrt_information;
  const Matrix<4, 4> expected = F * P * F.transpose() + (W * W).inverse();
  EXPECT_LT((window.covariance_at<Motion2>(A, 0) - P).norm(), 1e-9);
  EXPECT_LT((window.covariance_at<Motion2>(A, 0.4) - expected).norm(), 1e-9);
  window.at(A, 1.0);
  EXPECT_THROW(window.covariance_at<Motion2>(A, 0.5), BadTime);
}

// ---- arrival costs that are let go

/// At rest in 0 until it leaves the window; then all see it in z.
Window contradicted(double limit, double z) {
  WindowOptions options = twenty_states();
  options.max_states = 2;
  options.arrival_limit = limit;
  Window window(options);
  window.add_agent(A, [](double seconds) { return Motion::continuous(seconds, 1e-4); });
  window.add_state(A(0), 0.0, Motion2());
  window.add(Prior<Motion2>::from_sigmas(Motion2(), {0.1, 0.1, 0.1, 0.1}), {A(0)});
  for (int k = 1; k <= 3; ++k) {
    window.at(A, kStep * k);
    window.add(position({k < 3 ? 0 : z, 0}), {window.at(A, kStep * k)}, Squared{});
    window.step(kStep * k);
  }
  return window;
}

TEST(ArrivalLimit, LetsGoWhatTheAnswerContradicts) {
  const Window kept = contradicted(1e9, 80), let_go = contradicted(5, 80), agreed = contradicted(5, 0.3);
  EXPECT_EQ(kept.last_step().arrivals_let_go, 0);
  EXPECT_LT(kept.newest<Motion2>(A).value[0], 1);
  EXPECT_EQ(let_go.last_step().arrivals_let_go, 1);
  EXPECT_GT(let_go.newest<Motion2>(A).value[0], 10);
  EXPECT_EQ(agreed.last_step().arrivals_let_go, 0);
  EXPECT_THROW(contradicted(0, 1), BadOption);
}

}  // namespace
}  // namespace holdfast::testing
