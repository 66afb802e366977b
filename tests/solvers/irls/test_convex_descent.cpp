// irls on convex problems whose factors bend: range balls, where Gauss–Newton's JᵀJ is a poor model.
#include <gtest/gtest.h>

#include <cmath>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/factors/range_ball.hpp>
#include <holdfast/solvers/irls/irls.hpp>
#include <holdfast/solvers/table.hpp>
#include <holdfast/testing.hpp>

namespace holdfast {
namespace {

using testing::random_vector;
using testing::uniform;

constexpr Agent N('N'), L('L');

struct Problem {
  Graph graph;
  Values start;
};

/// Points in a square of 10 m, a third of them fixed, balls of the true distance with 2 % of noise between any two nearer than 5 m; start:
/// all at the centre.
Problem network(int points, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  Problem problem;
  std::vector<Vector<2>> truth;
  for (int i = 0; i < points; ++i) {
    truth.push_back(random_vector<2>(rng, 5));
    const bool anchor = i % 3 == 0;
    problem.start.insert(N(i), anchor ? Point2(truth[i]) : Point2(0, 0));
    if (anchor) problem.graph.fix(N(i));
  }
  for (int i = 0; i < points; ++i)
    for (int j = 0; j < i; ++j) {
      const double d = (truth[i] - truth[j]).norm();
      if (d < 5 && (i % 3 != 0 || j % 3 != 0))
        problem.graph.add(RangeBall<Point2, Point2>{d * (1 + uniform(rng, -0.04, 0.04)), 0.1}, {N(i), N(j)});
    }
  return problem;
}

/// Towards the anchor on a line: the answer is where the ball's surface is.
TEST(ConvexDescent, OneBallByHand) {
  Graph graph;
  Values values;
  values.insert(L(0), Point2(0, 0));
  values.insert(N(0), Point2(10, 0));
  graph.fix(L(0));
  graph.add(RangeBall<Point2, Point2>{3, 1}, {L(0), N(0)});
  graph.add(Prior<Point2>::from_sigmas(Point2(7, 0), Vector<2>(1, 1)), {N(0)});
  Options options;
  options.cost_tolerance = 1e-14;
  const Summary end = make_backend("irls", options)->solve(graph, values);
  EXPECT_TRUE(end.is_convex);
  EXPECT_LT((values.at<Point2>(N(0)).value - Vector<2>(5, 0)).norm(), 1e-9);  // half way between the ball and the prior
  EXPECT_NEAR(end.cost, 4, 1e-12);                                            // ½ 2² + ½ 2²
  EXPECT_LT(end.decrement, 1e-12);
}

TEST(ConvexDescent, AgreesWithAFirstOrderMethodFromTheCentre) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Problem problem = network(30, seed);
    Options options;
    options.cost_tolerance = 1e-13;
    Values newton = problem.start, accelerated = problem.start;
    const Summary a = make_backend("irls", options)->solve(problem.graph, newton);
    options.max_iterations = 100000;
    const Summary b = make_backend("nesterov", options)->solve(problem.graph, accelerated);
    EXPECT_EQ(a.termination, Termination::converged) << seed << ": " << a.str();
    EXPECT_NEAR(a.cost, b.cost, 1e-6 * b.cost + 1e-9) << seed;
    EXPECT_LT(a.iterations, 60) << seed;  // Gauss–Newton needs thousands, where it arrives at all
  }
}

TEST(ConvexDescent, TheSameFromAnyStart) {
  const Problem problem = network(30, 3);
  Options options;
  options.cost_tolerance = 1e-13;
  std::mt19937_64 rng(1);
  double first = -1;
  for (int run = 0; run < 10; ++run) {
    Values values = problem.start;
    for (const Key key : values.keys())
      if (!problem.graph.is_fixed(key)) values.update(key, Point2(random_vector<2>(rng, 50)));
    const double cost = make_backend("irls", options)->solve(problem.graph, values).cost;
    if (first < 0) first = cost;
    EXPECT_NEAR(cost, first, 1e-7 * first);
  }
}

// A step that a strong damping made short is no sign of a minimum: what `converged` says is held against a run to the bottom.
TEST(ConvexDescent, WhatConvergedIsWithinToleranceOfTheMinimum) {
  int converged = 0;
  for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-6})
    for (std::uint64_t seed = 0; seed < 50; ++seed) {
      const Problem problem = network(20 + 4 * static_cast<int>(seed), seed);
      Options options;
      options.cost_tolerance = 1e-14;
      Values bottom = problem.start;
      const double least = make_backend("irls", options)->solve(problem.graph, bottom).cost;
      options.cost_tolerance = tolerance;
      Values values = problem.start;
      const Summary end = make_backend("irls", options)->solve(problem.graph, values);
      if (end.termination != Termination::converged) continue;
      ++converged;
      EXPECT_LE(end.cost - least, tolerance * end.cost) << "seed " << seed << ", tolerance " << tolerance << ": " << end.str();
    }
  EXPECT_EQ(converged, 200);
}

TEST(ConvexDescent, IsNotTakenWhereSomethingIsNotConvex) {
  Problem problem = network(10, 0);
  EXPECT_TRUE(is_convex_problem(problem.graph));
  problem.graph.add(Range<Point2, Point2>{3, 0.1}, {N(1), N(2)});
  EXPECT_FALSE(is_convex_problem(problem.graph));
  Problem robust = network(10, 0);
  robust.graph.add(RangeBall<Point2, Point2>{3, 0.1}, {N(1), N(2)}, Cauchy{1});
  EXPECT_FALSE(is_convex_problem(robust.graph));
  EXPECT_FALSE(make_backend("irls")->solve(robust.graph, robust.start).is_convex);
}

TEST(ConvexDescent, AnAnswerStaysWhereItIs) {
  const Problem problem = network(30, 5);
  Options options;
  options.cost_tolerance = 1e-13;
  Values values = problem.start;
  const auto backend = make_backend("irls", options);
  const double cost = backend->solve(problem.graph, values).cost;
  const Summary again = backend->solve(problem.graph, values);
  EXPECT_NEAR(again.cost, cost, 1e-12 * cost);
  EXPECT_LE(again.iterations, 5);
}

}  // namespace
}  // namespace holdfast
