#include <gtest/gtest.h>

#include <holdfast/factors/between.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/solvers/incremental/incremental.hpp>
#include <holdfast/solvers/marginals.hpp>
#include <holdfast/solvers/table.hpp>
#include <holdfast/testing.hpp>
#include <map>

namespace holdfast {
namespace {

using testing::uniform;

constexpr Agent x('x'), L('L');
const Vector<3> kSigmas(0.05, 0.05, 0.02);

/// A walk on a grid: a step of 1 m, a quarter turn now and then; where it has been before it sees the pose that was there.
class Walk {
 public:
  explicit Walk(std::uint64_t seed) : rng_(seed) { truth_.push_back(Pose2(0, 0, 0)); }

  Pose2 noise() { return Pose2(kSigmas[0] * gauss(), kSigmas[1] * gauss(), kSigmas[2] * gauss()); }
  Pose2 measured(int i, int j) { return truth_[i].inverse() * truth_[j] * noise(); }
  /// The next true pose.
  void move() {
    const bool turn = uniform(rng_, 0, 1) < 0.3 || truth_.back().p.cwiseAbs().maxCoeff() > 5;
    truth_.push_back(truth_.back() * Pose2(0, 0, turn ? (uniform(rng_, 0, 1) < 0.5 ? 1 : -1) * M_PI / 2 : 0) * Pose2(1, 0, 0));
  }
  int seen_before(int k) {
    for (int i = 0; i < k - 5; ++i)
      if ((truth_[i].p - truth_[k].p).norm() < 0.1) return i;
    return -1;
  }
  double gauss() { return uniform(rng_, -1, 1) + uniform(rng_, -1, 1) + uniform(rng_, -1, 1); }

  std::mt19937_64 rng_;
  std::vector<Pose2> truth_;
};

Between<Pose2> between(const Pose2& measured) { return Between<Pose2>::from_sigmas(measured, kSigmas); }

double batch_cost(const Graph& graph, Values values) {
  Options options;
  options.cost_tolerance = 1e-13;
  return make_backend("irls", options)->solve(graph, values).cost;
}

TEST(Incremental, AWalkWithLoopsIsTheBatchAnswerAtEveryTenthStep) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Walk walk(seed);
    Incremental smoother;
    smoother.insert(x(0), walk.truth_[0]);
    smoother.add(Prior<Pose2>::from_sigmas(walk.truth_[0], kSigmas), {x(0)});
    smoother.update();
    for (int k = 1; k < 200; ++k) {
      walk.move();
      const Pose2 step = walk.measured(k - 1, k);
      smoother.insert(x(k), smoother.at<Pose2>(x(k - 1)) * step);
      smoother.add(between(step), {x(k - 1), x(k)});
      if (const int i = walk.seen_before(k); i >= 0) smoother.add(between(walk.measured(i, k)), {x(i), x(k)});
      smoother.update();
      if (k % 10 != 0) continue;
      const double cost = smoother.cost();
      EXPECT_NEAR(cost, batch_cost(smoother.graph(), smoother.values()), 1e-6 * cost + 1e-9) << seed << ' ' << k;
    }
    smoother.finish();
    EXPECT_NEAR(smoother.cost(), batch_cost(smoother.graph(), smoother.values()), 1e-9 * smoother.cost());
  }
}

TEST(Incremental, LinearProblemsAreExactInOneStep) {
  Incremental smoother;
  smoother.insert(L(0), Point2(0, 0));
  smoother.add(Prior<Point2>::from_sigmas(Point2(1, 2), Vector<2>(1, 1)), {L(0)});
  smoother.update();
  EXPECT_LT((smoother.at<Point2>(L(0)).value - Vector<2>(1, 2)).norm(), 1e-12);
  smoother.insert(L(1), Point2(0, 0));
  smoother.add(Between<Point2>::from_sigmas(Point2(3, 0), Vector<2>(1, 1)), {L(0), L(1)});
  const FactorId wrong = smoother.add(Prior<Point2>::from_sigmas(Point2(7, 2), Vector<2>(1, 1)), {L(1)});
  smoother.update();
  // Three equal springs share 3 m too much: 1 m each.
  EXPECT_LT((smoother.at<Point2>(L(0)).value - Vector<2>(2, 2)).norm(), 1e-9);
  EXPECT_LT((smoother.at<Point2>(L(1)).value - Vector<2>(6, 2)).norm(), 1e-9);
  EXPECT_NEAR(smoother.cost(), 1.5, 1e-9);
  const Eigen::MatrixXd S = smoother.covariance({L(0), L(1)});
  EXPECT_NEAR(S(0, 0), 2.0 / 3, 1e-12);
  EXPECT_NEAR(S(0, 2), 1.0 / 3, 1e-12);
  smoother.remove(wrong);
  smoother.update();
  EXPECT_LT((smoother.at<Point2>(L(1)).value - Vector<2>(4, 2)).norm(), 1e-9);
}

TEST(Incremental, CovariancesAreThoseOfMarginals) {
  Walk walk(5);
  Incremental smoother;
  smoother.insert(x(0), walk.truth_[0]);
  smoother.add(Prior<Pose2>::from_sigmas(walk.truth_[0], kSigmas), {x(0)});
  for (int k = 1; k < 60; ++k) {
    walk.move();
    const Pose2 step = walk.measured(k - 1, k);
    smoother.insert(x(k), walk.truth_[k]);
    smoother.add(between(step), {x(k - 1), x(k)});
    if (const int i = walk.seen_before(k); i >= 0) smoother.add(between(walk.measured(i, k)), {x(i), x(k)});
    smoother.update();
  }
  smoother.finish();
  const Marginals marginals(smoother.graph(), smoother.values());
  const Eigen::MatrixXd S = smoother.covariance({x(3), x(59)});
  EXPECT_LT((S.topLeftCorner(3, 3) - marginals.covariance<Pose2>(x(3))).norm(), 1e-9);
  EXPECT_LT((S.bottomRightCorner(3, 3) - marginals.covariance<Pose2>(x(59))).norm(), 1e-9);
}

/// Agents come and go, factors come and go, variables are marginalised: after each the batch answer of what is left.
TEST(Incremental, RandomLives) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    std::mt19937_64 rng(seed);
    IncrementalOptions options;
    options.most_steps = 50;
    options.relinearize = 1e-6;
    options.propagate = 0;
    options.reorder = seed % 2 == 0 ? 2 : 20;
    Incremental smoother(options);
    std::vector<Key> keys;
    std::vector<FactorId> removable;
    int next = 0;
    const auto pick = [&](std::size_t n) { return static_cast<std::size_t>(uniform(rng, 0, 1) * static_cast<double>(n)) % n; };
    std::map<Key, Pose2> truth;
    const auto noisy = [&](const Pose2& pose) {
      return pose * Pose2(uniform(rng, -0.1, 0.1), uniform(rng, -0.1, 0.1), uniform(rng, -0.03, 0.03));
    };
    const auto measured = [&](Key a, Key b) { return between(noisy(truth.at(a).inverse() * truth.at(b))); };
    for (int step = 0; step < 150; ++step) {
      const double what = uniform(rng, 0, 1);
      if (keys.size() < 3 || what < 0.45) {
        const Key key = x(next++);
        const Pose2 at(uniform(rng, -5, 5), uniform(rng, -5, 5), uniform(rng, -3, 3));
        truth[key] = at;
        smoother.insert(key, noisy(at));
        smoother.add(Prior<Pose2>::from_sigmas(noisy(at), Vector<3>(1, 1, 0.3)), {key});
        if (!keys.empty()) {
          const Key other = keys[pick(keys.size())];
          smoother.add(measured(other, key), {other, key}, Huber{3});
        }
        keys.push_back(key);
      } else if (what < 0.7) {
        const std::size_t i = pick(keys.size()), j = pick(keys.size());
        if (i != j) removable.push_back(smoother.add(measured(keys[i], keys[j]), {keys[i], keys[j]}, Huber{3}));
      } else if (what < 0.8 && !removable.empty()) {
        const std::size_t i = pick(removable.size());
        if (smoother.graph().contains(removable[i])) smoother.remove(removable[i]);
        removable.erase(removable.begin() + static_cast<std::ptrdiff_t>(i));
      } else if (what < 0.87) {
        const std::size_t i = pick(keys.size());
        smoother.erase(keys[i]);
        keys.erase(keys.begin() + static_cast<std::ptrdiff_t>(i));
      } else if (what < 0.92) {
        const std::size_t i = pick(keys.size());
        smoother.marginalize({keys[i]});
        keys.erase(keys.begin() + static_cast<std::ptrdiff_t>(i));
      }
      smoother.update();
      if (step % 10 != 9) continue;
      Values values = smoother.values();
      const double cost = smoother.cost(), batch = batch_cost(smoother.graph(), values);
      EXPECT_NEAR(cost, batch, 1e-5 * batch) << seed << ' ' << step;
    }
    smoother.finish();
    EXPECT_NEAR(smoother.cost(), batch_cost(smoother.graph(), smoother.values()), 1e-8 * smoother.cost() + 1e-12);
  }
}

/// Ranges to three beacons, one of them not known before: each step is the batch answer.
TEST(Incremental, ARangeGraphIsTheBatchAnswerAtEveryStep) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    std::mt19937_64 rng(seed);
    Incremental smoother;
    const Point2 beacons[3] = {Point2(0, 8), Point2(10, 8), Point2(5, -6)};
    for (int j = 0; j < 3; ++j) {
      smoother.insert(L(j), Point2(beacons[j].value + Vector<2>(uniform(rng, -1, 1), uniform(rng, -1, 1))));
      smoother.add(Prior<Point2>::from_sigmas(beacons[j], j < 2 ? Vector<2>(0.1, 0.1) : Vector<2>(5, 5)), {L(j)});
    }
    Pose2 truth(0, 0, 0);
    smoother.insert(x(0), truth);
    smoother.add(Prior<Pose2>::from_sigmas(truth, kSigmas), {x(0)});
    for (int k = 1; k < 40; ++k) {
      const Pose2 move(0.3, 0, uniform(rng, -0.2, 0.2));
      truth = truth * move;
      const Pose2 measured = move * Pose2(uniform(rng, -0.05, 0.05), uniform(rng, -0.05, 0.05), uniform(rng, -0.02, 0.02));
      smoother.insert(x(k), smoother.at<Pose2>(x(k - 1)) * measured);
      smoother.add(between(measured), {x(k - 1), x(k)});
      const int j = k % 3;
      const double d = (truth.p - beacons[j].value).norm() + uniform(rng, -0.1, 0.1);
      smoother.add(Range<Pose2, Point2>{d, 0.1}, {x(k), L(j)}, Huber{2});
      EXPECT_TRUE(smoother.update().settled);
      const double cost = smoother.cost();
      EXPECT_NEAR(cost, batch_cost(smoother.graph(), smoother.values()), 1e-5 * cost + 1e-9) << seed << ' ' << k;
    }
  }
}

TEST(Incremental, AFreeVariableIsNamedAndMendedByAPrior) {
  Incremental smoother;
  smoother.insert(x(0), Pose2(0, 0, 0));
  smoother.add(Prior<Pose2>::from_sigmas(Pose2(0, 0, 0), kSigmas), {x(0)});
  smoother.update();
  smoother.insert(x(1), Pose2(1, 0, 0));
  smoother.insert(L(0), Point2(3, 4));
  smoother.add(between(Pose2(1, 0, 0)), {x(0), x(1)});
  smoother.add(Range<Pose2, Point2>{5, 0.1}, {x(0), L(0)});  // a range alone leaves a direction free
  try {
    smoother.update();
    FAIL() << "a point under one range was taken";
  } catch (const Underdetermined& error) {
    EXPECT_NE(std::string(error.what()).find("L0"), std::string::npos) << error.what();
  }
  smoother.add(Prior<Point2>::from_sigmas(Point2(3, 4), Vector<2>(1, 1)), {L(0)});
  smoother.update();
  EXPECT_LT((smoother.at<Pose2>(x(1)).p - Vector<2>(1, 0)).norm(), 1e-6);
  EXPECT_LT(smoother.cost(), 1e-9);
}

TEST(Incremental, FixedVariablesStay) {
  Incremental smoother;
  smoother.insert(x(0), Pose2(1, 2, 0));
  smoother.fix(x(0));
  smoother.insert(x(1), Pose2(0, 0, 0));
  smoother.add(between(Pose2(1, 0, 0)), {x(0), x(1)});
  smoother.update();
  EXPECT_LT((smoother.at<Pose2>(x(1)).p - Vector<2>(2, 2)).norm(), 1e-9);
  EXPECT_EQ(smoother.at<Pose2>(x(0)).p, Vector<2>(1, 2));
  EXPECT_THROW(smoother.fix(x(1)), BadKey);
  EXPECT_THROW(smoother.covariance({x(0)}), BadKey);
}

TEST(Incremental, FinishOfConstantsAloneDoesNothing) {
  Incremental smoother;
  EXPECT_EQ(smoother.finish().termination, Termination::converged);
  smoother.insert(x(0), Pose2(1, 0, 0));
  smoother.fix(x(0));
  smoother.add(Prior<Pose2>::from_sigmas(Pose2(0, 0, 0), Vector<3>(1, 1, 1)), {x(0)});
  EXPECT_NEAR(smoother.finish().cost, 0.5, 1e-12);
}

TEST(Incremental, BadInputLeavesItAsItWas) {
  Incremental smoother;
  smoother.insert(x(0), Pose2(0, 0, 0));
  smoother.add(Prior<Pose2>::from_sigmas(Pose2(0, 0, 0), kSigmas), {x(0)});
  smoother.update();
  EXPECT_THROW(smoother.insert(x(0), Pose2()), BadKey);
  EXPECT_THROW(smoother.add(between(Pose2()), {x(0), x(9)}), BadKey);
  smoother.insert(L(0), Point2(0, 0));
  EXPECT_THROW(smoother.add(between(Pose2()), {x(0), L(0)}), BadType);
  EXPECT_EQ(smoother.graph().size(), 1u);
  EXPECT_THROW(Incremental(IncrementalOptions{0, 0, 1, 1}), BadOption);
}

}  // namespace
}  // namespace holdfast
