#include <gtest/gtest.h>

#include <holdfast/factors/between.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/solvers/internal/measured_distance.hpp>
#include <holdfast/solvers/range_consistency.hpp>
#include <set>

#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

constexpr Agent A('A'), B('B'), L('L');
constexpr double kSigma = 0.1;  // [m] of a range

// ---- what a range is

TEST(MeasuredDistance, IsThatOfRangesAlone) {
  Graph graph;
  graph.add(Range<Pose2, Point2>{7, 0.2}, {A(0), L(0)});
  graph.add(Range<Point3, Pose3>{0, 0.3}, {L(1), B(0)});
  graph.add(RangeBall<Pose2, Point2>{7, 0.2}, {A(0), L(0)});
  graph.add(Between<Pose2>::from_sigmas(Pose2(), Vector<3>(1, 1, 1)), {A(0), A(1)});
  const auto measured = [&](int batch) { return holdfast::detail::measured_distance(*graph.batches()[batch], 0); };
  ASSERT_TRUE(measured(0) && measured(1));
  EXPECT_NEAR(measured(0)->distance, 7, 1e-12);
  EXPECT_NEAR(measured(0)->sigma, 0.2, 1e-12);
  EXPECT_NEAR(measured(1)->distance, 0, 1e-12);
  EXPECT_NEAR(measured(1)->sigma, 0.3, 1e-12);
  EXPECT_FALSE(measured(2));  // one-sided
  EXPECT_FALSE(measured(3));
}

// ---- tracks

struct Ranging {
  Graph graph;
  std::set<int> echoes;  ///< numbers of FactorId
  std::vector<FactorId> ranges;
  std::mt19937_64 rng{3};

  double chance() { return std::uniform_real_distribution<double>(0, 1)(rng); }

  /// A walk of a robot and its odometry, with noise.
  template <class Pose>
  std::vector<Pose> walk(Agent agent, int poses, Pose here) {
    constexpr int n = Pose::space_dim;
    std::vector<Pose> truth;
    Vector<Pose::dim> sigmas = Vector<Pose::dim>::Constant(0.002);
    sigmas.template head<n>().setConstant(0.01);
    for (int k = 0; k < poses; ++k) {
      if (k > 0) {
        Vector<Pose::dim> step = Vector<Pose::dim>::Zero();
        step[0] = 0.5;
        if (n == 3) step[2] = 0.3 * std::sin(0.2 * k);
        step[Pose::dim - 1] = 0.3 * std::sin(0.11 * k);
        const Pose moved = Pose{}.retract(step);
        here = here * moved;
        const Pose measured = moved * Pose{}.retract(random_vector<Pose::dim>(rng, 1).cwiseProduct(sigmas).eval());
        graph.add(Between<Pose>::from_sigmas(measured, sigmas), {agent(k - 1), agent(k)});
      }
      truth.push_back(here);
    }
    return truth;
  }

  template <class V, class W>
  void range(Key a, const V& x, Key b, const W& y, double share) {
    double distance = (x.position() - y.position()).norm() + kSigma * random_vector<1>(rng, 1)[0];
    const bool echo = chance() < share;
    if (echo) distance += 1 + 10 * chance();
    const FactorId id = graph.add(Range<V, W>{std::max(0.0, distance), kSigma}, {a, b});
    ranges.push_back(id);
    if (echo) echoes.insert(id.number);
  }

  /// Of the echoes those that are gone, and of the true ranges those that are not.
  std::pair<double, double> shares(const ConsistentRanges& found) const {
    double gone = 0, lost = 0;
    for (const FactorId id : found.rejected) (echoes.count(id.number) != 0 ? gone : lost) += 1;
    const double many = static_cast<double>(echoes.size());
    return {gone / many, lost / (static_cast<double>(ranges.size()) - many)};
  }
};

template <class Pose>
void find_echoes_of_a_beacon(double share) {
  using Point = std::conditional_t<Pose::space_dim == 2, Point2, Point3>;
  Ranging problem;
  const auto truth = problem.walk<Pose>(A, 200, Pose{});
  Vector<Pose::space_dim> where = Vector<Pose::space_dim>::LinSpaced(4, 9);
  for (int k = 0; k < 200; ++k) problem.range(A(k), truth[k], L(0), Point(where), share);
  const ConsistentRanges found = consistent_ranges(problem.graph);
  const auto [gone, lost] = problem.shares(found);
  EXPECT_GT(gone, 0.97) << found.str();
  EXPECT_LT(lost, 0.03) << found.str();
  EXPECT_EQ(found.kept.size() + found.rejected.size(), 200u);
  EXPECT_EQ(found.untested, 0u);
  EXPECT_EQ(found.groups, 1u);
}

TEST(ConsistentRanges, FindEchoesOfABeaconInThePlane) {
  for (const double share : {0.2, 0.4, 0.6}) find_echoes_of_a_beacon<Pose2>(share);
}
TEST(ConsistentRanges, FindEchoesOfABeaconInSpace) {
  for (const double share : {0.2, 0.4}) find_echoes_of_a_beacon<Pose3>(share);
}

// Their tracks start a quarter turn and several metres from each other, of which nothing is known.
TEST(ConsistentRanges, FindEchoesBetweenTwoRobotsInThePlane) {
  Ranging problem;
  const auto first = problem.walk<Pose2>(A, 160, Pose2{});
  const auto second = problem.walk<Pose2>(B, 160, Pose2(12, -5, 1.6));
  for (int k = 0; k < 160; ++k)
    if (k % 2 == 0)
      problem.range(A(k), first[k], B(159 - k), second[159 - k], 0.3);
    else
      problem.range(B(159 - k), second[159 - k], A(k), first[k], 0.3);
  const ConsistentRanges found = consistent_ranges(problem.graph);
  const auto [gone, lost] = problem.shares(found);
  EXPECT_GT(gone, 0.95) << found.str();
  EXPECT_LT(lost, 0.05) << found.str();
}

// Four ranges in the plane agree with one place or not; three say nothing.
TEST(ConsistentRanges, FourJudgeAndThreeDoNot) {
  for (const int count : {3, 4, 5}) {
    Ranging problem;
    const auto truth = problem.walk<Pose2>(A, count, Pose2{});
    for (int k = 0; k < count; ++k) problem.range(A(k), truth[k], L(0), Point2(1, 3), 0);
    const ConsistentRanges found = consistent_ranges(problem.graph);
    EXPECT_EQ(found.untested, count < 4 ? 3u : 0u) << found.str();
    EXPECT_TRUE(found.rejected.empty()) << found.str();
  }
}

TEST(ConsistentRanges, ARangeThatNothingTiesToATrackIsKept) {
  Graph graph;
  for (int k = 0; k < 10; ++k) graph.add(Range<Pose2, Point2>{1.0 + 7 * k, kSigma}, {A(2 * k), L(0)});  // no odometry
  for (int k = 0; k < 10; ++k) graph.add(Range<Point2, Point2>{1.0 + 7 * k, kSigma}, {L(k), L(k + 1)});
  const ConsistentRanges found = consistent_ranges(graph);
  EXPECT_EQ(found.kept.size(), 20u);
  EXPECT_EQ(found.untested, 20u);
  EXPECT_EQ(found.groups, 0u);
}

TEST(ConsistentRanges, AreTheSameEachTimeAndInTheGraphsOrder) {
  Ranging problem;
  const auto truth = problem.walk<Pose2>(A, 100, Pose2{});
  for (int k = 99; k >= 0; --k) problem.range(A(k), truth[k], L(0), Point2(3, 8), 0.4);
  const ConsistentRanges one = consistent_ranges(problem.graph), other = consistent_ranges(problem.graph);
  const auto by_number = [](FactorId a, FactorId b) { return a.number < b.number; };
  ASSERT_EQ(one.rejected.size(), other.rejected.size());
  for (std::size_t i = 0; i < one.rejected.size(); ++i) EXPECT_EQ(one.rejected[i].number, other.rejected[i].number);
  EXPECT_TRUE(std::is_sorted(one.kept.begin(), one.kept.end(), by_number));
}

TEST(RangeConsistencyOptions, HaveRules) {
  Graph graph;
  const FactorId range = graph.add(Range<Pose2, Point2>{1, kSigma}, {A(0), L(0)});
  const auto refuses = [&](auto&& change) {
    RangeConsistencyOptions options;
    change(options);
    EXPECT_THROW(consistent_ranges(graph, options), BadOption);
  };
  refuses([](auto& o) { o.false_alarm = 0; });
  refuses([](auto& o) { o.window = 7; });
  refuses([](auto& o) { o.drift = -1; });
  refuses([](auto& o) { o.least_share = 1.5; });
  refuses([](auto& o) { o.proposals = 0; });
  refuses([](auto& o) { o.turns = 3; });
  refuses([](auto& o) { o.noise_scale = -1; });
  RangeConsistencyOptions options;
  options.odometry = {range};
  EXPECT_THROW(consistent_ranges(graph, options), BadType);
}

}  // namespace
}  // namespace holdfast::testing
