#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/graph/function_factor.hpp>
#include <holdfast/graph/gradient.hpp>
#include <holdfast/solvers/gnc.hpp>
#include <holdfast/solvers/outlier_report.hpp>
#include <holdfast/solvers/table.hpp>
#include <holdfast/testing.hpp>

namespace holdfast {
namespace {

using ::testing::HasSubstr;
using testing::random_vector;
using testing::uniform;

constexpr Agent x('x'), L('L');

/// Range<Pose2, Point2> as a function: (‖p_b − p_a‖ − d) / σ. A pose's coordinates are x y cos sin.
std::shared_ptr<FunctionFactors> ranges(const std::vector<double>& distances, double sigma, bool with_jacobian) {
  auto f = std::make_shared<FunctionFactors>();
  f->name = "MyRange";
  f->types = {&Pool<Pose2>::prototype(), &Pool<Point2>::prototype()};
  f->residual_dim = 1;
  f->has_jacobian = with_jacobian;
  f->evaluate = [=](const FunctionCall& call) {
    for (int i = 0; i < call.n; ++i) {
      const double* a = call.x[0] + 4 * i;
      const double* b = call.x[1] + 2 * i;
      const double dx = b[0] - a[0], dy = b[1] - a[1], d = std::hypot(dx, dy);
      call.r[i] = (d - distances[call.number[i]]) / sigma;
      if (call.J.empty()) continue;
      const double u[2] = {dx / d / sigma, dy / d / sigma};
      for (int c = 0; c < 2; ++c) {
        call.J[0][3 * i + c] = -u[c];
        call.J[1][2 * i + c] = u[c];
      }
      call.J[0][3 * i + 2] = 0;
    }
  };
  return f;
}

struct Problem {
  Graph graph;
  Values values;
  std::vector<Key> keys;
  std::vector<double> distances;
};

/// Poses with priors, and points that they range to.
Problem problem(int poses = 40) {
  std::mt19937_64 rng(1);
  Problem p;
  for (int i = 0; i < 3; ++i) p.values.insert(L(i), Point2(random_vector<2>(rng, 10)));
  for (int i = 0; i < poses; ++i) {
    const Pose2 pose(uniform(rng, -5, 5), uniform(rng, -5, 5), uniform(rng, -3, 3));
    p.values.insert(x(i), pose);
    p.graph.add(Prior<Pose2>::from_sigmas(pose, Vector<3>(0.5, 0.5, 0.1)), {x(i)});
    for (int j = 0; j < 3; ++j) {
      p.keys.insert(p.keys.end(), {x(i), L(j)});
      p.distances.push_back((pose.p - p.values.at<Point2>(L(j)).value).norm() + uniform(rng, -0.3, 0.3));
    }
  }
  p.distances[p.distances.size() / 2] += 4;  // an outlier
  return p;
}

Problem with_functions(bool jacobian, const Loss& loss = {}) {
  Problem p = problem();
  p.graph.add(ranges(p.distances, 0.1, jacobian), p.keys, loss);
  return p;
}
Problem with_factors(const Loss& loss = {}) {
  Problem p = problem();
  for (std::size_t i = 0; i < p.distances.size(); ++i)
    p.graph.add(Range<Pose2, Point2>{p.distances[i], 0.1}, {p.keys[2 * i], p.keys[2 * i + 1]}, loss);
  return p;
}

TEST(FunctionFactors, CostAndGradientAreThoseOfTheFactor) {
  const Problem factors = with_factors();
  for (const bool jacobian : {false, true}) {
    const Problem functions = with_functions(jacobian);
    EXPECT_NEAR(functions.graph.cost(functions.values), factors.graph.cost(factors.values), 1e-9);
    const std::vector<double> a = gradient(functions.graph, functions.values).value, b = gradient(factors.graph, factors.values).value;
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-5 * (1 + std::abs(b[i]))) << i;
  }
}

TEST(FunctionFactors, EveryBackendEndsWhereTheFactorsDo) {
  Options options;
  options.cost_tolerance = 1e-12;
  for (const Loss& loss : {Loss(), Loss(Huber{2})}) {
    Problem factors = with_factors(loss);
    const double cost = make_backend("irls", options)->solve(factors.graph, factors.values).cost;
    for (const std::string& name : backend_names()) {
      if (name.rfind("ceres-", 0) == 0) continue;
      for (const int threads : {1, 3}) {
        Problem functions = with_functions(name != "irls", loss);
        Options own = options;
        own.threads = threads;
        const Summary end = make_backend(name, own)->solve(functions.graph, functions.values);
        EXPECT_TRUE(end.usable()) << name << ": " << end.str();
        EXPECT_NEAR(end.cost, cost, 1e-5 * cost) << name << ' ' << loss.str();
      }
    }
  }
}

TEST(FunctionFactors, InGncAndInTheOutlierReport) {
  Problem functions = with_functions(true, TruncatedSquares{3});
  const Summary end = make_backend("gnc-irls")->solve(functions.graph, functions.values);
  EXPECT_TRUE(end.usable()) << end.str();
  int outliers = 0;
  for (const MeasurementReport& one : outlier_report(functions.graph, functions.values))
    if (one.verdict == MeasurementReport::Verdict::outlier) {
      ++outliers;
      EXPECT_EQ(one.factor, "MyRange");
    }
  EXPECT_EQ(outliers, 1);
}

TEST(FunctionFactors, RemovedOnesAreGoneAndOthersKeepTheirNumbers) {
  Problem p = problem(3);
  const std::vector<FactorId> ids = p.graph.add(ranges(p.distances, 0.1, false), p.keys);
  const double before = p.graph.residual(ids[8], p.values)[0];
  p.graph.remove(ids[0]);
  EXPECT_EQ(p.graph.residual(ids[8], p.values)[0], before);
  const Graph copy = p.graph;
  EXPECT_EQ(copy.residual(ids[8], p.values)[0], before);
  p.graph.set_loss(ids[8], Cauchy{1});  // into a batch of its own
  EXPECT_EQ(p.graph.residual(ids[8], p.values)[0], before);
  Graph other;
  EXPECT_EQ(other.residual(other.add_from(p.graph, ids[8]), p.values)[0], before);
}

TEST(FunctionFactors, TwoFunctionsAreNotMixed) {
  Problem p = problem(1);
  const auto first = ranges(p.distances, 0.1, false), second = ranges(p.distances, 0.2, false);
  const FactorId a = p.graph.add(first, {x(0), L(0)}, Huber{1})[0], b = p.graph.add(second, {x(0), L(0)}, Cauchy{1})[0];
  const double ra = p.graph.residual(a, p.values)[0], rb = p.graph.residual(b, p.values)[0];
  EXPECT_NEAR(ra, 2 * rb, 1e-9);
  p.graph.set_loss(b, Huber{1});
  EXPECT_EQ(p.graph.residual(b, p.values)[0], rb);
  EXPECT_EQ(p.graph.residual(a, p.values)[0], ra);
}

TEST(FunctionFactors, WhatItThrowsEndsTheSolveByName) {
  Problem p = problem(2);
  auto bad = ranges(p.distances, 0.1, false);
  int calls = 0;
  bad->evaluate = [&, inner = bad->evaluate](const FunctionCall& call) {
    if (++calls > 3) throw std::runtime_error("no more today");
    inner(call);
  };
  p.graph.add(bad, p.keys);
  const Values before = p.values;
  const Summary end = make_backend("irls")->solve(p.graph, p.values);
  EXPECT_EQ(end.termination, Termination::failed);
  EXPECT_THAT(end.why(), HasSubstr("MyRange: no more today"));
  EXPECT_EQ(p.values.at<Point2>(L(0)).value, before.at<Point2>(L(0)).value);
}

TEST(FunctionFactors, BadOnesAreRefused) {
  Graph graph;
  auto f = ranges({1}, 0.1, false);
  EXPECT_THROW(graph.add(f, {x(0)}), BadKey);
  EXPECT_THROW(graph.add(f, {x(0), x(0)}), BadKey);
  f->residual_dim = 0;
  EXPECT_THROW(graph.add(f, {x(0), L(0)}), BadOption);
  EXPECT_EQ(graph.size(), 0u);
}

}  // namespace
}  // namespace holdfast
