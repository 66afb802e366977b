// Bad input and bad luck, in every back-end: a typed error or a failure that names the culprit, and values as they were.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/backends.hpp"
#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

using ::testing::HasSubstr;

constexpr Agent A('A'), B('B'), L('L');

class AnyBackend : public ::testing::TestWithParam<std::string> {
 protected:
  /// Expects E from solve(), and values as they were; returns the message.
  template <class E>
  std::string refusal(const Graph& graph, const Values& values, const Options& options = {}) {
    Values x = values;
    std::string message;
    try {
      const Summary summary = solve(GetParam(), graph, x, options);
      ADD_FAILURE() << "no error: " << summary.str();
    } catch (const E& error) {
      message = error.what();
    }
    EXPECT_TRUE(same_bits(x, values));
    return message;
  }
  /// Expects Termination::failed, and values as they were; returns why.
  std::string failure(const Graph& graph, const Values& values) {
    Values x = values;
    const Summary summary = solve(GetParam(), graph, x);
    EXPECT_EQ(summary.termination, Termination::failed) << summary.str();
    EXPECT_FALSE(summary.usable());
    EXPECT_TRUE(same_bits(x, values));
    return summary.why();
  }
};

std::string label(const ::testing::TestParamInfo<std::string>& info) {
  std::string text = info.param;
  std::replace(text.begin(), text.end(), '-', '_');
  return text;
}
INSTANTIATE_TEST_SUITE_P(Backends, AnyBackend, ::testing::ValuesIn(every_backend()), label);

Prior<Point2> prior_at(double x, double y) { return Prior<Point2>::from_sigmas(Point2(x, y), Vector<2>(1, 1)); }

Values two_points() {
  Values values;
  values.insert(A(0), Point2(0, 0));
  values.insert(A(1), Point2(1, 2));
  return values;
}

/// Two points with priors and a range between them.
Graph pair_graph() {
  Graph graph;
  graph.add(prior_at(0, 0), {A(0)});
  graph.add(prior_at(3, 0), {A(1)});
  graph.add(Range<Point2, Point2>{2, 0.1}, {A(0), A(1)});
  return graph;
}

TEST_P(AnyBackend, RefusesAnEmptyGraph) {
  EXPECT_THAT(refusal<BadProblem>(Graph(), two_points()), HasSubstr("no factors"));
  Graph emptied;
  emptied.remove(emptied.add(prior_at(0, 0), {A(0)}));
  EXPECT_THAT(refusal<BadProblem>(emptied, two_points()), HasSubstr("no factors"));
}

TEST_P(AnyBackend, RefusesAProblemWithNothingFree) {
  Graph graph;
  graph.add(prior_at(1, 1), {A(0)});
  graph.fix(A(0));
  EXPECT_THAT(refusal<BadProblem>(graph, two_points()), HasSubstr("fixed"));
}

TEST_P(AnyBackend, NamesAKeyWithoutAValue) {
  Graph graph = pair_graph();
  graph.add(Range<Point2, Point2>{2, 0.1}, {A(0), B(4)});
  const std::string message = refusal<BadKey>(graph, two_points());
  EXPECT_THAT(message, HasSubstr("Range(A0, B4)"));
  EXPECT_THAT(message, HasSubstr("Point2"));
}

TEST_P(AnyBackend, NamesAWrongType) {
  Values values;
  values.insert(A(0), Point2(0, 0));
  values.insert(A(1), Point3(0, 0, 0));
  const std::string message = refusal<BadType>(pair_graph(), values);
  EXPECT_THAT(message, HasSubstr("A1"));
  EXPECT_THAT(message, HasSubstr("Point3"));
}

TEST_P(AnyBackend, RefusesOptionsOutOfRange) {
  const auto expect_refused = [&](const char* field, auto change) {
    Options options;
    change(options);
    EXPECT_THAT(refusal<BadOption>(pair_graph(), two_points(), options), HasSubstr(field));
  };
  expect_refused("max_iterations", [](Options& o) { o.max_iterations = -1; });
  expect_refused("cost_tolerance", [](Options& o) { o.cost_tolerance = -1e-9; });
  expect_refused("cost_tolerance", [](Options& o) { o.cost_tolerance = NAN; });
  expect_refused("gradient_tolerance", [](Options& o) { o.gradient_tolerance = -1; });
  expect_refused("gradient_tolerance", [](Options& o) { o.gradient_tolerance = NAN; });
  expect_refused("threads", [](Options& o) { o.threads = 0; });
  expect_refused("threads", [](Options& o) { o.threads = 1025; });
  expect_refused("time_limit", [](Options& o) { o.time_limit = 0; });
  expect_refused("time_limit", [](Options& o) { o.time_limit = NAN; });
}

TEST_P(AnyBackend, NamesTheFactorOfANonFiniteStart) {
  for (const double bad : {static_cast<double>(NAN), static_cast<double>(INFINITY)}) {
    Values values = two_points();
    values.at<Point2>(A(1)).value[1] = bad;
    const std::string why = failure(pair_graph(), values);
    EXPECT_THAT(why, HasSubstr("Prior(A1)"));
    EXPECT_THAT(why, HasSubstr("not finite"));
    EXPECT_THAT(why, HasSubstr("A1 = [1"));
  }
}

TEST_P(AnyBackend, NamesTheFactorWhereAFixedVariableIsNotFinite) {
  Graph graph = pair_graph();
  graph.fix(A(1));
  Values values = two_points();
  values.at<Point2>(A(1)).value[0] = NAN;
  EXPECT_THAT(failure(graph, values), HasSubstr("A1"));
}

// Every residual is finite, but its square is not.
TEST_P(AnyBackend, NamesTheFactorWhoseSquareOverflows) {
  Graph graph;
  graph.add(prior_at(0, 0), {A(0)});
  graph.add(prior_at(0, 0), {A(1)});
  Values values = two_points();
  values.at<Point2>(A(1)).value[0] = 1e200;
  EXPECT_THAT(failure(graph, values), HasSubstr("Prior(A1)"));
}

/// √x − 1: not a number beyond zero.
struct Root {
  using Variables = variables<Scalar>;
  static constexpr int residual_dim = 1;
  static const char* name() { return "Root"; }
  Vector<1> operator()(const Scalar& x, Jacobians<Root>* J = nullptr) const {
    const double root = std::sqrt(x.value);
    if (J != nullptr) J->all(0, 0) = 0.5 / root;
    return Vector<1>(root - 0.01);
  }
};

TEST_P(AnyBackend, StepsBackFromWhereAResidualIsNotFinite) {
  Graph graph;
  graph.add(Root{}, {A(0)});  // from 4 a Gauss–Newton step lands below zero
  Values values;
  values.insert(A(0), Scalar(4));
  const Summary summary = solve(GetParam(), graph, values);
  ASSERT_TRUE(summary.usable()) << summary.str();
  EXPECT_TRUE(std::isfinite(values.at<Scalar>(A(0)).value));
  EXPECT_TRUE(std::isfinite(summary.cost));
  EXPECT_LT(summary.cost, summary.cost_first);
  EXPECT_NEAR(values.at<Scalar>(A(0)).value, 1e-4, 1e-5);
}

TEST_P(AnyBackend, ExceptionFromTheCallbackLeavesValues) {
  const auto problem = slam<Pose2>(1, 6, 0.1);
  Values values = problem.start;
  Options options;
  options.progress = [](const Iteration& iteration) {
    if (iteration.number >= 1) throw std::runtime_error("the user's own");
    return true;
  };
  EXPECT_THROW(solve(GetParam(), problem.graph, values, options), std::runtime_error);
  EXPECT_TRUE(same_bits(values, problem.start));
}

TEST_P(AnyBackend, IsUsableAgainAfterAFailure) {
  const auto backend = make_backend(GetParam());
  Values bad = two_points(), good = two_points();
  bad.at<Point2>(A(0)).value[0] = NAN;
  const Graph graph = pair_graph();
  EXPECT_FALSE(backend->solve(graph, bad).usable());
  EXPECT_THROW(backend->solve(Graph(), good), BadProblem);
  EXPECT_TRUE(backend->solve(graph, good).usable());
  EXPECT_LT(graph.cost(good), graph.cost(two_points()));
}

void expect_all_finite(const Values& values) {
  for (const auto& pool : values.pools())
    for (int i = 0; i < pool->size(); ++i) EXPECT_TRUE(pool->is_finite(i)) << pool->keys()[i];
}

// Conventions, "Zero distance": finite always, the Jacobian is zero there.
TEST_P(AnyBackend, SolvesCoincidentAgents) {
  Graph graph;
  graph.add(Range<Point2, Point2>{2, 0.1}, {A(0), A(1)});
  graph.add(RangeBall<Point2, Point2>{2, 0.1}, {A(0), A(1)});
  graph.add(VonMisesBearing<Point2, Point2>{{1, 0}, 10}, {A(0), A(1)});
  graph.add(VonMisesBearingBody<Pose2, Point2>{{1, 0}, 10}, {B(0), A(1)});
  graph.add(Range<Pose2, Point2>{1, 0.1}, {B(0), A(1)});
  graph.add(prior_at(0, 0), {A(0)});
  graph.add(prior_at(0.5, 0), {A(1)});
  graph.add(Prior<Pose2>::from_sigmas(Pose2(), Vector<3>(1, 1, 1)), {B(0)});
  Values values;
  values.insert(A(0), Point2(0, 0));
  values.insert(A(1), Point2(0, 0));
  values.insert(B(0), Pose2());
  const Summary summary = solve(GetParam(), graph, values);
  ASSERT_TRUE(summary.usable()) << summary.str();
  expect_all_finite(values);
  EXPECT_LE(summary.cost, summary.cost_first);
  EXPECT_TRUE(std::isfinite(summary.gradient_norm));
}

TEST_P(AnyBackend, SolvesWhatOnlyRangesHoldAtZeroDistance) {
  Graph graph;
  graph.add(Range<Point3, Point3>{1, 0.1}, {A(0), A(1)});
  Values values;
  values.insert(A(0), Point3(1, 1, 1));
  values.insert(A(1), Point3(1, 1, 1));
  const Summary summary = solve(GetParam(), graph, values);
  EXPECT_TRUE(summary.usable()) << summary.str();  // a stationary point, if not a good one
  expect_all_finite(values);
}

TEST_P(AnyBackend, SolvesAFreeGauge) {
  std::mt19937_64 rng(2);
  Graph graph;
  Values values;
  for (int i = 0; i < 6; ++i) values.insert(A(i), random_variable<Pose3>(rng));
  for (int i = 1; i < 6; ++i) {
    const Pose3 measured = values.at<Pose3>(A(i - 1)).inverse() * values.at<Pose3>(A(i));
    graph.add(Between<Pose3>::from_sigmas(measured.retract(random_vector<6>(rng, 0.1)), Vector<6>::Constant(0.1)), {A(i - 1), A(i)});
  }
  const Summary summary = solve(GetParam(), graph, values);
  EXPECT_TRUE(summary.usable()) << summary.str();
  expect_all_finite(values);
  EXPECT_LT(summary.cost, 1e-6 * summary.cost_first);  // a chain can be satisfied exactly
}

TEST_P(AnyBackend, SolvesFreeLinearDirections) {
  Graph graph;
  for (int i = 1; i < 5; ++i) graph.add(Between<Point2>::from_sigmas(Point2(1, 0), Vector<2>(0.1, 0.1)), {L(i - 1), L(i)});
  Values values;
  for (int i = 0; i < 5; ++i) values.insert(L(i), Point2(0, i));
  const Summary summary = solve(GetParam(), graph, values);
  EXPECT_TRUE(summary.usable()) << summary.str();
  expect_all_finite(values);
  EXPECT_LT(summary.cost, 1e-6 * summary.cost_first);
}

TEST_P(AnyBackend, SolvesADisconnectedRobotBesideTheOthers) {
  Graph both = pair_graph();
  both.add(prior_at(7, 7), {B(0)});
  Values values = two_points(), alone = two_points();
  values.insert(B(0), Point2(0, 0));
  ASSERT_TRUE(solve(GetParam(), both, values).usable());
  ASSERT_TRUE(solve(GetParam(), pair_graph(), alone).usable());
  EXPECT_LT((values.at<Point2>(B(0)).value - Vector<2>(7, 7)).norm(), 1e-5);
  EXPECT_LT((values.at<Point2>(A(1)).value - alone.at<Point2>(A(1)).value).norm(), 1e-5);
}

TEST_P(AnyBackend, SolvesWhereEveryBallIsInactive) {
  Graph graph;
  graph.add(RangeBall<Point2, Point2>{10, 0.1}, {A(0), A(1)});
  const Values start = two_points();
  Values values = start;
  const Summary summary = solve(GetParam(), graph, values);
  EXPECT_EQ(summary.termination, Termination::converged) << summary.str();
  EXPECT_EQ(summary.cost, 0);
  EXPECT_LT(largest_difference(start, values), 1e-12);
}

TEST_P(AnyBackend, SolvesWhereTheOnlyFactorOfAVariableWeighsNothing) {
  Graph graph = pair_graph();
  graph.add(prior_at(5, 5), {B(0)}, Squared{}, 0);
  Values values = two_points();
  values.insert(B(0), Point2(1, 1));
  const Summary summary = solve(GetParam(), graph, values);
  EXPECT_TRUE(summary.usable()) << summary.str();
  expect_all_finite(values);
  EXPECT_LT((values.at<Point2>(B(0)).value - Vector<2>(1, 1)).norm(), 1e-6);
}

}  // namespace
}  // namespace holdfast::testing
