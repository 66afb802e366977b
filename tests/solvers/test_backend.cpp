// What Options mean and what a Summary says, the same in every back-end.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "tests/backends.hpp"
#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

using ::testing::HasSubstr;

class Contract : public ::testing::TestWithParam<std::string> {};

std::string label(const ::testing::TestParamInfo<std::string>& info) {
  std::string text = info.param;
  std::replace(text.begin(), text.end(), '-', '_');
  return text;
}
INSTANTIATE_TEST_SUITE_P(Backends, Contract, ::testing::ValuesIn(every_backend()), label);

SmallProblem hard() { return slam<Pose3>(1, 20, 0.2, Cauchy{1}, 0.4); }

TEST_P(Contract, HasTheNameItWasAskedBy) { EXPECT_EQ(make_backend(GetParam())->name(), GetParam()); }

TEST_P(Contract, KeepsTheOptionsItWasMadeWith) {
  Options options;
  options.max_iterations = 17;
  EXPECT_EQ(make_backend(GetParam(), options)->options.max_iterations, 17);
}

TEST_P(Contract, SummaryIsTrueOfTheAnswer) {
  for (const auto& problem : {hard(), slam<Pose2>(2, 12, 0.1, Huber{2}), tracking<Motion2>(3, 15, 0.3, Huber{2})}) {
    Values values = problem.start;
    const Summary summary = solve(GetParam(), problem.graph, values);
    EXPECT_EQ(summary.termination, Termination::converged) << summary.str();
    EXPECT_NEAR(summary.cost_first, problem.graph.cost(problem.start), 1e-12 * summary.cost_first);
    EXPECT_NEAR(summary.cost, problem.graph.cost(values), 1e-10 * summary.cost);
    EXPECT_LE(summary.cost, summary.cost_first);
    EXPECT_GT(summary.iterations, 0);
    EXPECT_STRNE(summary.rule, "");
    EXPECT_TRUE(summary.trace.empty());
  }
}

/// A prior at 1 that takes its time.
struct SlowPrior {
  static constexpr double kSeconds = 0.01;
  using Variables = variables<Scalar>;
  static constexpr int residual_dim = 1;
  static const char* name() { return "SlowPrior"; }
  Vector<1> operator()(const Scalar& x, Jacobians<SlowPrior>* J = nullptr) const {
    std::this_thread::sleep_for(std::chrono::duration<double>(kSeconds));
    if (J != nullptr) J->all(0, 0) = 1;
    return Vector<1>(x.value - 1);
  }
};

TEST_P(Contract, SaysWhereTheTimeWent) {
  Graph graph;
  graph.add(SlowPrior{}, {Key('x', 0)});
  Values values;
  values.insert(Key('x', 0), Scalar(3));
  const Summary summary = make_backend(GetParam())->solve(graph, values);
  EXPECT_TRUE(summary.usable()) << summary.str();
  EXPECT_GE(summary.seconds, 2 * SlowPrior::kSeconds);  // the cost at the start, and the gradient there, at least
  EXPECT_GE(summary.seconds_setup + summary.seconds_linearize + summary.seconds_solve, SlowPrior::kSeconds);
  EXPECT_LE(summary.seconds_setup + summary.seconds_linearize + summary.seconds_solve, summary.seconds);
}

/// After a few steps only, where the gradient is far from zero.
TEST_P(Contract, GradientNormIsThatOfTheAnswer) {
  for (const int iterations : {1, 2, 3}) {
    const auto problem = slam<Pose3>(4, 12, 0.3, Huber{1}, 0.5);
    Values values = problem.start;
    Options options;
    options.max_iterations = iterations;
    const Summary summary = solve(GetParam(), problem.graph, values, options);
    const double truth = max_gradient(problem.graph, values);
    EXPECT_NEAR(summary.gradient_norm, truth, 1e-6 * truth) << iterations << " iterations";
  }
}

TEST_P(Contract, StopsAtTheIterationLimit) {
  if (GetParam() == kGnc) GTEST_SKIP() << "max_iterations holds for each of the inner solves of GNC, as it says (solvers/gnc.hpp)";
  const auto problem = hard();
  for (const int limit : {1, 2, 3}) {
    Values values = problem.start;
    Options options;
    options.max_iterations = limit;
    const Summary summary = solve(GetParam(), problem.graph, values, options);
    EXPECT_EQ(summary.termination, Termination::iteration_limit) << summary.str();
    EXPECT_EQ(summary.iterations, limit);
    EXPECT_TRUE(summary.usable());
    EXPECT_THAT(summary.str(), HasSubstr("max_iterations"));
  }
}

TEST_P(Contract, StopsAtTheTimeLimitWithTheBestSoFar) {
  const auto problem = slam<Pose3>(5, 400, 0.2, Cauchy{1}, 0.3);
  Values values = problem.start;
  Options options = to_the_bottom();
  options.time_limit = 1e-6;
  const Summary summary = solve(GetParam(), problem.graph, values, options);
  EXPECT_EQ(summary.termination, Termination::time_limit) << summary.str();
  EXPECT_TRUE(summary.usable());
  EXPECT_LE(problem.graph.cost(values), problem.graph.cost(problem.start) * (1 + 1e-12));
}

TEST_P(Contract, StopsWhenTheCallbackSaysSo) {
  const auto problem = hard();
  Values values = problem.start;
  Options options = to_the_bottom();
  std::vector<Iteration> seen;
  options.progress = [&](const Iteration& iteration) {
    seen.push_back(iteration);
    return seen.size() < 4;
  };
  const Summary summary = solve(GetParam(), problem.graph, values, options);
  EXPECT_EQ(summary.termination, Termination::stopped) << summary.str();
  EXPECT_EQ(seen.size(), 4u);
  EXPECT_TRUE(summary.usable());
  EXPECT_NEAR(summary.cost, problem.graph.cost(values), 1e-10 * summary.cost);
}

TEST_P(Contract, TraceRunsFromTheStartToTheAnswerAndNeverUp) {
  auto problem = hard();
  problem.graph.fix(Key('A', 3));  // costs that no free variable moves count, too
  problem.graph.fix(Key('A', 4));
  Values values = problem.start;
  Options options = to_the_bottom();
  options.trace = true;
  std::vector<double> reported;
  options.progress = [&](const Iteration& iteration) {
    reported.push_back(iteration.cost);
    return true;
  };
  const Summary summary = solve(GetParam(), problem.graph, values, options);
  ASSERT_GT(summary.trace.size(), 2u);
  EXPECT_EQ(reported.size(), summary.trace.size());
  EXPECT_EQ(summary.trace.front().number, 0);
  EXPECT_NEAR(summary.trace.front().cost, summary.cost_first, 1e-12 * summary.cost_first);
  EXPECT_NEAR(summary.trace.back().cost, summary.cost, 1e-6 * summary.cost);
  for (std::size_t i = 1; i < summary.trace.size(); ++i) {
    EXPECT_LE(summary.trace[i].cost, summary.trace[i - 1].cost * (1 + 1e-14)) << i;
    EXPECT_GT(summary.trace[i].number, summary.trace[i - 1].number) << i;
    EXPECT_GE(summary.trace[i].seconds, summary.trace[i - 1].seconds) << i;
  }
}

TEST_P(Contract, TraceBeginsWithTheGradientAtTheStart) {
  const auto problem = tracking<Motion2>(6, 15, 0.3, Huber{2});  // a vector space: no back-end can mean another norm
  Values values = problem.start;
  Options options = to_the_bottom();
  options.trace = true;
  const Summary summary = solve(GetParam(), problem.graph, values, options);
  const double truth = max_gradient(problem.graph, problem.start);
  EXPECT_NEAR(summary.trace.front().gradient_norm, truth, 1e-9 * truth);
}

TEST_P(Contract, GradientToleranceEndsASolve) {
  const auto problem = tracking<Motion2>(7, 15, 0.3, PseudoHuber{2});
  Values values = problem.start;
  Options options = to_the_bottom();
  options.cost_tolerance = 0;
  options.gradient_tolerance = 1e-3;
  const Summary summary = solve(GetParam(), problem.graph, values, options);
  EXPECT_EQ(summary.termination, Termination::converged) << summary.str();
  EXPECT_LT(max_gradient(problem.graph, values), 1e-2);
}

TEST_P(Contract, LooseCostToleranceEndsEarly) {
  const auto problem = hard();
  Values loose = problem.start, tight = problem.start;
  Options options = to_the_bottom();
  const int many = solve(GetParam(), problem.graph, tight, options).iterations;
  options.cost_tolerance = 0.3;
  const Summary summary = solve(GetParam(), problem.graph, loose, options);
  EXPECT_EQ(summary.termination, Termination::converged);
  EXPECT_LT(summary.iterations, many);
}

TEST_P(Contract, WeightsScaleTheCostAndNotTheAnswer) {
  const auto build = [](double weight) {
    Graph graph;
    graph.add(Prior<Point2>::from_sigmas(Point2(0, 0), Vector<2>(1, 2)), {Key('A', 0)}, Huber{1}, weight);
    graph.add(Prior<Point2>::from_sigmas(Point2(5, 1), Vector<2>(1, 1)), {Key('A', 0)}, Huber{1}, 2 * weight);
    return graph;
  };
  Values one, seven;
  one.insert(Key('A', 0), Point2(1, 1));
  seven.insert(Key('A', 0), Point2(1, 1));
  const Summary a = solve(GetParam(), build(1), one), b = solve(GetParam(), build(7), seven);
  EXPECT_NEAR(b.cost, 7 * a.cost, 1e-8 * b.cost);
  EXPECT_LT(largest_difference(one, seven), 1e-4);
}

TEST(Options, DefaultsAreValid) { EXPECT_NO_THROW(Options().validate()); }

TEST(Options, ErrorsShowValueAndRule) {
  Options options;
  options.threads = -3;
  try {
    options.validate();
    FAIL();
  } catch (const BadOption& error) {
    EXPECT_THAT(error.what(), HasSubstr("-3"));
    EXPECT_THAT(error.what(), HasSubstr("between 1 and 1024"));
  }
}

TEST(Summary, ReadsLikeASentence) {
  Summary summary;
  summary.termination = Termination::failed;
  summary.rule = "the cost at the start is not finite";
  summary.culprit = "Range(A0, L0)";
  EXPECT_EQ(summary.why(), "the cost at the start is not finite: Range(A0, L0)");
  EXPECT_THAT(summary.str(), HasSubstr("failed"));
  EXPECT_FALSE(summary.usable());
}

}  // namespace
}  // namespace holdfast::testing
