#include <gtest/gtest.h>

#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/range_bearing.hpp>
#include <holdfast/factors/white_acceleration.hpp>
#include <holdfast/solvers/convex_start.hpp>
#include <holdfast/solvers/table.hpp>
#include <holdfast/testing.hpp>

namespace holdfast {
namespace {

using testing::random_vector;
using testing::uniform;

constexpr Agent N('N'), L('L');

Options tight() {
  Options options;
  options.cost_tolerance = 1e-12;
  return options;
}

struct Problem {
  Graph graph;
  Values truth;
};

Values anywhere(const Problem& problem, std::uint64_t seed, double size) {
  std::mt19937_64 rng(seed);
  Values values = problem.truth;
  for (Key key : values.keys())
    if (values.contains<Motion2>(key))
      values.at<Motion2>(key).value = random_vector<4>(rng, size);
    else if (values.contains<Point2>(key) && !problem.graph.is_fixed(key))
      values.at<Point2>(key).value = random_vector<2>(rng, size);
  return values;
}

/// A target that crosses a square of four anchors, seen from each by exact ranges and bearings.
Problem crossing() {
  Problem problem;
  for (int i = 0; i < 4; ++i) {
    problem.truth.insert(L(i), Point2(i % 2 == 0 ? -10.0 : 10.0, i < 2 ? -10.0 : 10.0));
    problem.graph.fix(L(i));
  }
  for (int k = 0; k < 10; ++k) {
    problem.truth.insert(N(k), Motion2(-5.0 + k, 1.0, 0.5 * k, 0.5));
    if (k > 0) problem.graph.add(WhiteAcceleration<Motion2>::continuous(1, 0.1), {N(k - 1), N(k)});
    for (int i = 0; i < 4; ++i) {
      const Vector<2> x = problem.truth.at<Point2>(L(i)).value - problem.truth.at<Motion2>(N(k)).position();
      problem.graph.add(RangeBearing<Motion2, Point2>{x.norm(), 0.5, x / x.norm(), 6000}, {N(k), L(i)});
    }
  }
  return problem;
}

/// Points that know their distances to the nearest others, inside a ring of anchors: balls alone place them nearly.
Problem inside_a_ring(std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  Problem problem;
  for (int i = 0; i < 8; ++i) {
    problem.truth.insert(L(i), Point2(20 * std::cos(i * kPi / 4), 20 * std::sin(i * kPi / 4)));
    problem.graph.fix(L(i));
  }
  for (int i = 0; i < 12; ++i) problem.truth.insert(N(i), Point2(uniform(rng, -8, 8), uniform(rng, -8, 8)));
  for (int i = 0; i < 12; ++i) {
    const auto p = [&](Key key) { return problem.truth.at<Point2>(key).value; };
    for (int j = 0; j < 8; ++j) problem.graph.add(Range<Point2, Point2>{(p(N(i)) - p(L(j))).norm(), 0.5}, {N(i), L(j)});
    for (int j = 0; j < i; ++j) problem.graph.add(Range<Point2, Point2>{(p(N(i)) - p(N(j))).norm(), 0.5}, {N(i), N(j)});
  }
  return problem;
}

double largest_error(const Problem& problem, const Values& values) {
  double largest = 0;
  for (Key key : problem.truth.keys()) {
    const auto position = [&](const Values& v) {
      return v.contains<Motion2>(key) ? v.at<Motion2>(key).position() : v.at<Point2>(key).value;
    };
    largest = std::max(largest, (position(values) - position(problem.truth)).norm());
  }
  return largest;
}

TEST(ConvexStart, FindsTheTruthFromNothing) {
  for (const Problem& problem : {crossing(), inside_a_ring(1), inside_a_ring(2)})
    for (const char* name : {"irls", "nesterov"}) {
      const auto backend = make_backend(name, tight());
      Values values = anywhere(problem, 3, 1000);
      const ConvexStart found = convex_start(problem.graph, values, *backend);
      EXPECT_TRUE(found.start.is_convex);
      EXPECT_EQ(found.refined.termination, Termination::converged) << name << ": " << found.refined.str();
      EXPECT_LT(largest_error(problem, values), 1e-4) << name;
    }
}

TEST(ConvexStart, ReportsTheCostOfEachStage) {
  const Problem problem = inside_a_ring(4);
  const auto backend = make_backend("irls", tight());
  Values values = anywhere(problem, 1, 10), at_origin = problem.truth;
  const ConvexStart found = convex_start(problem.graph, values, *backend);
  for (int i = 0; i < 12; ++i) at_origin.at<Point2>(N(i)) = Point2(0, 0);  // the centre of the anchors
  EXPECT_NEAR(found.start.cost_centroid, problem.graph.cost(at_origin), 1e-9 * found.start.cost_centroid);
  EXPECT_NEAR(found.start.relaxed.cost_first, problem.graph.relaxed().cost(at_origin), 1e-9 * found.start.relaxed.cost_first);
  EXPECT_EQ(found.start.cost, found.refined.cost_first);
  EXPECT_LT(found.start.cost, found.start.cost_centroid);
  EXPECT_LE(found.start.relaxed.cost, found.refined.cost + 1e-9);  // a relaxation bounds from below
  EXPECT_NE(found.start.str().find("convex problem"), std::string::npos);
}

TEST(ConvexStart, DoesNotDependOnTheValuesGiven) {
  const Problem problem = crossing();
  Values a = anywhere(problem, 1, 1), b = anywhere(problem, 2, 1e4);
  relaxed_start(problem.graph, a, tight());
  relaxed_start(problem.graph, b, tight());
  for (int k = 0; k < 10; ++k) EXPECT_LT((a.at<Motion2>(N(k)).value - b.at<Motion2>(N(k)).value).norm(), 1e-5) << k;
}

/// A chain of balls that pull each agent to the next, held at both ends only: a flat valley, where IRLS ends at its limit.
TEST(ConvexStart, GoesOnByNesterovWhereIrlsIsNotDone) {
  Graph graph;
  Values values;
  constexpr int n = 400;
  for (int i = 0; i < n; ++i) {
    values.insert(N(i), Point2(0, 0));
    if (i > 0) graph.add(Range<Point2, Point2>{1, 0.1}, {N(i - 1), N(i)}, Absolute{1e-3});
  }
  values.at<Point2>(N(n - 1)) = Point2(3.0 * n, 40);
  graph.fix(N(0));
  graph.fix(N(n - 1));
  Options quick = tight(), patient = tight();
  quick.max_iterations = 200;
  patient.max_iterations = 1000;
  Values early = values;
  const RelaxedStart first = relaxed_start(graph, early, quick), start = relaxed_start(graph, values, patient);
  EXPECT_EQ(first.relaxed.iterations, 200);
  EXPECT_GT(start.relaxed.iterations, 200);
  EXPECT_LE(start.relaxed.iterations, 1000);
  EXPECT_LT(start.relaxed.cost, first.relaxed.cost);
  EXPECT_EQ(start.relaxed.cost_first, first.relaxed.cost_first);
  EXPECT_NEAR(start.relaxed.cost, graph.relaxed().cost(values), 1e-9 * start.relaxed.cost);
}

TEST(ConvexStart, BeginsAtTheCentroidOfPriorsWhereNothingIsFixed) {
  Graph graph;
  graph.add(Prior<Point2>::from_sigmas(Point2(10, 0), Vector<2>(1, 1)), {N(0)});
  graph.add(Prior<Point2>::from_sigmas(Point2(20, 6), Vector<2>(1, 1)), {N(1)});
  graph.add(Range<Point2, Point2>{0, 1}, {N(1), N(2)});
  Values values;
  for (int i = 0; i < 3; ++i) values.insert(N(i), Point2(-100, 500));
  EXPECT_NEAR(relaxed_start(graph, values).cost_centroid, 2 * 0.5 * (25 + 9), 1e-6);  // all at (15, 3)
}

TEST(ConvexStart, KeepsRotationsAndMovesOnlyWhatIsFree) {
  Graph graph;
  graph.add(Range<Pose2, Point2>{5, 1}, {N(0), L(0)});
  graph.add(Prior<Pose2>::from_sigmas(Pose2(3, 0, 0.7), Vector<3>(0.1, 0.1, 0.1)), {N(0)});
  graph.fix(L(0));
  Values values;
  values.insert(N(0), Pose2(500, 500, 0.7));
  values.insert(L(0), Point2(7, 0));
  const RelaxedStart start = relaxed_start(graph, values, tight());
  EXPECT_TRUE(start.relaxed.usable());
  EXPECT_TRUE(values.at<Pose2>(N(0)).heading.isApprox(Pose2(0, 0, 0.7).heading, 1e-9));
  EXPECT_LT((values.at<Pose2>(N(0)).position() - Vector<2>(3, 0)).norm(), 1e-6);
  EXPECT_EQ(values.at<Point2>(L(0)).value, Vector<2>(7, 0));
}

TEST(ConvexStart, IsOneProblemWithRedescendingLosses) {
  Problem problem = inside_a_ring(5);
  problem.graph.add(Range<Point2, Point2>{1, 0.5}, {N(0), L(0)}, TruncatedSquares{3});  // false: it is nearly 20 m
  const auto backend = make_backend("irls", tight());
  Values values = anywhere(problem, 1, 100);
  const ConvexStart found = convex_start(problem.graph, values, *backend);
  EXPECT_TRUE(found.start.is_convex);
  EXPECT_LT(largest_error(problem, values), 1e-4);
}

TEST(ConvexStart, LeavesValuesAloneWhereItFails) {
  Problem problem = crossing();
  Values values = problem.truth;
  values.at<Point2>(L(0)) = Point2(NAN, 0);
  const auto backend = make_backend("irls");
  const Values before = values;
  EXPECT_FALSE(convex_start(problem.graph, values, *backend).refined.usable());
  EXPECT_EQ(values.at<Motion2>(N(3)).value, before.at<Motion2>(N(3)).value);
}

}  // namespace
}  // namespace holdfast
