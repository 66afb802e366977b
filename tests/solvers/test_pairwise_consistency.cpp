#include <gtest/gtest.h>

#include <holdfast/solvers/internal/independent_set.hpp>
#include <holdfast/solvers/pairwise_consistency.hpp>
#include <set>

#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

constexpr Agent A('A'), B('B');

// ---- the largest set without conflicts

std::size_t largest_by_trying_all(const std::vector<std::vector<int>>& conflicts) {
  const int n = static_cast<int>(conflicts.size());
  std::size_t largest = 0;
  for (unsigned set = 0; set < (1u << n); ++set) {
    bool is_free = true;
    for (int i = 0; i < n && is_free; ++i)
      if ((set >> i & 1) != 0)
        for (int j : conflicts[i]) is_free = is_free && (set >> j & 1) == 0;
    if (is_free) largest = std::max(largest, static_cast<std::size_t>(__builtin_popcount(set)));
  }
  return largest;
}

TEST(IndependentSet, IsTheLargest) {
  std::mt19937_64 rng(1);
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 1 + static_cast<int>(rng() % 14);
    std::vector<std::vector<int>> conflicts(n);
    for (int i = 0; i < n; ++i)
      for (int j = i + 1; j < n; ++j)
        if (rng() % 10 < static_cast<unsigned>(trial % 10)) {
          conflicts[i].push_back(j);
          conflicts[j].push_back(i);
        }
    for (double time : {0.0, 10.0}) {
      const auto found = holdfast::detail::largest_independent_set(conflicts, time);
      for (int i : found.members)
        for (int j : conflicts[i]) EXPECT_FALSE(std::binary_search(found.members.begin(), found.members.end(), j));
      if (time > 0) {
        EXPECT_TRUE(found.is_exact);
        EXPECT_EQ(found.members.size(), largest_by_trying_all(conflicts));
      }
    }
  }
}

// ---- loops

/// Walks of two robots in one room, with odometry, and loops within and between them.
template <class V>
struct Walks {
  static constexpr int turns = rotation_dim<V::space_dim>;
  std::mt19937_64 rng;
  double noise;  ///< as drawn; the stated sigma is noise · overstated
  double overstated;
  Values truth;
  Graph graph;
  std::set<int> false_ones;

  Walks(std::uint64_t seed, int poses, double sigma, double stated = 1) : rng(seed), noise(sigma), overstated(stated) {
    for (const Agent agent : {A, B}) {
      V x = V{}.retract((Vector<V::dim>() << random_vector<V::space_dim>(rng, 2), random_vector<turns>(rng, 0.3)).finished());
      for (int i = 0; i < poses; ++i) {
        truth.insert(agent(i), x);
        x = x * random_step<V>(rng, 0.5, 0.2);
      }
      for (int i = 1; i < poses; ++i) tie(agent(i - 1), agent(i));
    }
  }
  V pose(Key key) const { return truth.at<V>(key); }
  V noisy(const V& exact) {
    return exact * V{}.retract((Vector<V::dim>() << random_vector<V::space_dim>(rng, noise), random_vector<turns>(rng, noise)).finished());
  }
  FactorId add(Key a, Key b, const V& measured) {
    return graph.add(Between<V>::from_sigmas(measured, Vector<V::dim>::Constant(noise * overstated)), {a, b});
  }
  FactorId tie(Key a, Key b) { return add(a, b, noisy(pose(a).inverse() * pose(b))); }
  Key random_key(Agent agent, int poses) { return agent(rng() % static_cast<unsigned>(poses)); }

  void add_true_loops(int count, int poses, Agent first, Agent second) {
    for (int k = 0; k < count;) {
      const Key a = random_key(first, poses), b = random_key(second, poses);
      if (first == second && std::max(a, b).step() - std::min(a, b).step() < 3) continue;
      tie(a, b);
      ++k;
    }
  }
  /// False loops that agree with each other: the second place is taken for another one.
  void add_false_group(int count, int poses, Agent first, Agent second, double error) {
    const unsigned span = static_cast<unsigned>(poses - count);
    const auto i = rng() % span, j = rng() % span;
    const V away = V{}.retract(
        (Vector<V::dim>() << error * random_vector<V::space_dim>(rng, 1).normalized(), random_vector<turns>(rng, 1)).finished());
    const V to_first = pose(first(i)), wrong = to_first * away * to_first.inverse();
    for (int k = 0; k < count; ++k)
      if (first(i + k) != second(j + k) && !(first == second && std::max(i, j) - std::min(i, j) < 2))
        false_ones.insert(add(first(i + k), second(j + k), noisy(pose(first(i + k)).inverse() * wrong * pose(second(j + k)))).number);
  }
  std::size_t false_kept(const ConsistentLoops& found) const {
    return static_cast<std::size_t>(
        std::count_if(found.kept.begin(), found.kept.end(), [&](FactorId id) { return false_ones.count(id.number) != 0; }));
  }
};

template <class V>
class Pcm : public ::testing::Test {};
using PoseTypes = ::testing::Types<Pose2, Pose3>;
TYPED_TEST_SUITE(Pcm, PoseTypes);

PairwiseConsistencyOptions as_stated() {
  PairwiseConsistencyOptions options;
  options.noise_scale = 1;
  return options;
}

// χ² has its distribution: as many pairs of true loops disagree as false_alarm says, whatever stretches of odometry they share.
TYPED_TEST(Pcm, FalseAlarmsAreAsRareAsTheyAreSaidToBe) {
  for (const bool between : {false, true}) {
    std::size_t pairs = 0, disagreeing = 0;
    for (int seed = 0; seed < 60; ++seed) {
      Walks<TypeParam> walks(static_cast<std::uint64_t>(seed), 40, 0.005);
      walks.add_true_loops(12, 40, A, between ? B : A);
      PairwiseConsistencyOptions options = as_stated();
      options.false_alarm = 0.1;
      const ConsistentLoops found = consistent_loops(walks.graph, options);
      pairs += found.pairs;
      disagreeing += found.disagreeing;
      EXPECT_EQ(found.kept.size() + found.rejected.size(), 12u);
      EXPECT_EQ(found.groups, 1u);
    }
    EXPECT_EQ(pairs, 60u * 66u);
    EXPECT_NEAR(static_cast<double>(disagreeing) / static_cast<double>(pairs), 0.1, 0.035);
  }
}

TYPED_TEST(Pcm, RejectsFalseLoopsThatAgreeWithEachOther) {
  for (int seed = 0; seed < 10; ++seed) {
    for (const auto& [first, second] : {std::pair{A, A}, std::pair{A, B}}) {
      Walks<TypeParam> walks(static_cast<std::uint64_t>(seed), 60, 0.01);
      walks.add_true_loops(30, 60, first, second);
      walks.add_false_group(10, 60, first, second, 5);
      walks.add_false_group(10, 60, first, second, 5);
      const ConsistentLoops found = consistent_loops(walks.graph, as_stated());
      EXPECT_EQ(walks.false_kept(found), 0u) << found.str();
      EXPECT_LE(found.rejected.size(), walks.false_ones.size() + 1) << found.str();
      EXPECT_TRUE(found.is_exact);
      EXPECT_EQ(found.untested, 0u);
    }
  }
}

TYPED_TEST(Pcm, TakesEdgesThatAreWrittenTheOtherWayRound) {
  Walks<TypeParam> walks(3, 60, 0.01);
  walks.add_true_loops(20, 60, A, B);
  walks.add_true_loops(20, 60, A, A);
  walks.add_false_group(10, 60, A, B, 5);
  Graph turned;
  walks.graph.template for_each_batch<Between<TypeParam>>([&](const auto& batch) {
    for (int i = 0; i < batch.size(); ++i) {  // the noise is nearly the same in all directions, so it may stay
      Between<TypeParam> factor = batch.factors()[i];
      factor.measured = factor.measured.inverse();
      turned.add(factor, {batch.keys(i)[1], batch.keys(i)[0]});
    }
  });
  const ConsistentLoops found = consistent_loops(turned, as_stated());
  EXPECT_EQ(walks.false_kept(found), 0u) << found.str();
  EXPECT_LE(found.rejected.size(), walks.false_ones.size() + 4) << found.str();
}

TYPED_TEST(Pcm, EstimatesTheScaleOfTheNoise) {
  Walks<TypeParam> exact(5, 150, 0.01), overstated(5, 150, 0.01, 10);
  for (auto* walks : {&exact, &overstated}) {
    walks->add_true_loops(60, 150, A, A);
    for (int k = 0; k < 3; ++k) walks->add_false_group(10, 150, A, A, 4);
  }
  const double of_exact = consistent_loops(exact.graph).noise_scale;
  EXPECT_GT(of_exact, 0.5);
  const ConsistentLoops found = consistent_loops(overstated.graph);  // the variances are stated 100 times too large
  EXPECT_GT(found.noise_scale, 0.01);
  EXPECT_LT(found.noise_scale, 0.1);
  EXPECT_EQ(overstated.false_kept(found), 0u) << found.str();
  EXPECT_LE(found.rejected.size(), overstated.false_ones.size() + 1) << found.str();
}

// Laps of one ring: dead reckoning knows nothing of far laps, so pairs cannot tell; but the map, over the loops from lap to lap, can.
TYPED_TEST(Pcm, TheMapSeesMoreThanPairs) {
  using V = TypeParam;
  constexpr int kLap = 30, kLaps = 20, kPoses = kLap * kLaps;
  std::size_t without = 0, with = 0, loops = 0, rejected = 0;
  for (int seed = 0; seed < 5; ++seed) {
    Walks<V> walks(static_cast<std::uint64_t>(seed), 2, 0.06);
    walks.graph = Graph();
    walks.truth = Values();
    Vector<V::dim> step = Vector<V::dim>::Zero();
    step[0] = 1;
    step[V::dim - 1] = 2 * kPi / kLap;
    V x;
    for (int i = 0; i < kPoses; ++i, x = x * V{}.retract(step)) walks.truth.insert(A(i), x);
    for (int i = 1; i < kPoses; ++i) walks.tie(A(i - 1), A(i));
    for (int i = kLap; i < kPoses; i += 2, ++loops) walks.tie(A(i), A(i - kLap));
    for (int k = 0; k < 6; ++k) walks.add_false_group(12, kPoses, A, A, 6);
    PairwiseConsistencyOptions options = as_stated();
    options.second_look = false;
    without += walks.false_kept(consistent_loops(walks.graph, options));
    options.second_look = true;
    const ConsistentLoops found = consistent_loops(walks.graph, options);
    with += walks.false_kept(found);
    rejected += found.rejected.size() - (walks.false_ones.size() - walks.false_kept(found));
  }
  EXPECT_GT(without, 100u) << with;
  EXPECT_LT(10 * with, 8 * without) << with;
  EXPECT_LT(rejected, loops / 50);
}

TEST(PairwiseConsistency, WhatFitsTheAnswerAgrees) {
  Walks<Pose2> walks(4, 60, 0.02);
  walks.add_true_loops(10, 60, A, A);
  walks.add_false_group(5, 60, A, A, 5);
  std::vector<FactorId> loops = consistent_loops(walks.graph, as_stated()).rejected;
  ASSERT_EQ(loops.size(), walks.false_ones.size());
  const FactorId fits = walks.tie(A(3), A(40));
  loops.push_back(fits);
  const std::vector<FactorId> back = agreeing_loops(walks.graph, walks.truth, loops, 1e-4);
  ASSERT_EQ(back.size(), 1u);
  EXPECT_EQ(back[0].number, fits.number);
  EXPECT_THROW(agreeing_loops(walks.graph, walks.truth, loops, 0), BadOption);
}

TEST(PairwiseConsistency, KeepsALoopThatNothingCanBeSaidOf) {
  Walks<Pose2> walks(1, 30, 0.01);
  walks.tie(A(2), B(3));
  const ConsistentLoops found = consistent_loops(walks.graph);
  EXPECT_EQ(found.kept.size(), 1u);
  EXPECT_EQ(found.untested, 1u);
  EXPECT_EQ(found.tracks, 2u);
  EXPECT_EQ(found.groups, 0u);
  EXPECT_TRUE(consistent_loops(Graph()).kept.empty());
}

TEST(PairwiseConsistency, TakesTheOdometryItIsTold) {
  Walks<Pose2> walks(2, 30, 0.01);
  PairwiseConsistencyOptions options = as_stated();
  walks.graph.for_each_batch<Between<Pose2>>([&](const Batch<Between<Pose2>>& batch) {
    for (int i = 0; i < batch.size(); ++i) options.odometry.push_back(walks.graph.id_of(0, i));
  });
  const FactorId seam = walks.tie(A(10), A(11));  // a second edge between neighbours: a loop, if it is not named
  EXPECT_TRUE(consistent_loops(walks.graph).kept.empty());
  const ConsistentLoops found = consistent_loops(walks.graph, options);
  ASSERT_EQ(found.kept.size(), 1u);
  EXPECT_EQ(found.kept[0].number, seam.number);
}

TEST(PairwiseConsistency, NamesWhatIsWrong) {
  Walks<Pose2> walks(1, 5, 0.01);
  PairwiseConsistencyOptions options;
  options.false_alarm = 1;
  EXPECT_THROW(consistent_loops(walks.graph, options), BadOption);
  options = {};
  options.noise_scale = -1;
  EXPECT_THROW(consistent_loops(walks.graph, options), BadOption);
  options = {};
  options.odometry = {FactorId{1000, 0}};
  EXPECT_THROW(consistent_loops(walks.graph, options), BadKey);
  const FactorId prior = walks.graph.add(Prior<Pose2>::from_sigmas(Pose2(), Vector<3>(1, 1, 1)), {A(0)});
  options.odometry = {prior};
  EXPECT_THROW(consistent_loops(walks.graph, options), BadType);
}

}  // namespace
}  // namespace holdfast::testing
