#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <holdfast/factors/between.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/graph/gradient.hpp>
#include <holdfast/solvers/second_order.hpp>
#include <holdfast/solvers/table.hpp>
#include <holdfast/testing.hpp>

namespace holdfast {
namespace {

using testing::random_vector;
using testing::uniform;
using Verdict = SecondOrder::Verdict;

constexpr Agent N('N'), L('L');
constexpr int kProblems = 200;

enum class Start { plane, line, point };

struct Problem {
  Graph graph;
  Values start;
};

/// 2 to 5 points that range to 4 to 6 fixed anchors and to each other. The start keeps every gradient in the plane or on the line of all
/// anchors, or has all points in one place. There every second problem has the same anchor ranges for all, so that they
/// would stay together.
Problem ranges(std::uint64_t seed, Start kind) {
  std::mt19937_64 rng(seed);
  Problem problem;
  const int anchors = 4 + static_cast<int>(seed % 3), points = 2 + static_cast<int>(seed % 4);
  const bool in_one_place = kind == Start::point, same = in_one_place && seed % 2 == 1;
  std::vector<Vector<3>> truth;
  const auto shaped = [&](Vector<3> p) {
    if (kind == Start::plane || kind == Start::line) p[2] = 0;
    if (kind == Start::line) p[1] = 0;
    return p;
  };
  for (int i = 0; i < anchors; ++i) {
    const Vector<3> p = shaped(random_vector<3>(rng, 10));
    problem.start.insert(L(i), Point3(p));
    problem.graph.fix(L(i));
    truth.push_back(p);
  }
  for (int i = 0; i < points; ++i) {
    truth.push_back(random_vector<3>(rng, 6));
    problem.start.insert(N(i), Point3(in_one_place ? Vector<3>(1, 2, 3) : shaped(random_vector<3>(rng, 6))));
  }
  const auto range = [&](int i, int j, Key a, Key b) {
    const double d = std::abs((truth[i] - truth[j]).norm() + uniform(rng, -0.1, 0.1));
    problem.graph.add(Range<Point3, Point3>{d, 0.1}, {a, b});
  };
  for (int i = 0; i < points; ++i) {
    for (int j = 0; j < anchors; ++j)
      if (same)
        problem.graph.add(Range<Point3, Point3>{(truth[anchors] - truth[j]).norm(), 2}, {N(i), L(j)});
      else
        range(anchors + i, j, N(i), L(j));
    for (int j = 0; j < i; ++j) range(anchors + i, anchors + j, N(i), N(j));
  }
  return problem;
}

/// The least eigenvalue of the dense Hessian, relative to the largest: differences of the gradient, with nothing of second_order.cpp.
double least_eigenvalue(const Graph& graph, const Values& values) {
  constexpr double h = 1e-6;
  const Resolved resolved(graph, values);
  const int n = resolved.tangent_dim();
  Eigen::MatrixXd H(n, n);
  Values moved = values;
  for (int i = 0; i < n; ++i) {
    Eigen::VectorXd delta = Eigen::VectorXd::Zero(n);
    delta[i] = h;
    resolved.retract(values, delta.data(), moved);
    const std::vector<double> ahead = gradient(graph, moved).value;
    delta[i] = -h;
    resolved.retract(values, delta.data(), moved);
    const std::vector<double> behind = gradient(graph, moved).value;
    for (int j = 0; j < n; ++j) H(j, i) = (ahead[j] - behind[j]) / (2 * h);
  }
  const Eigen::VectorXd e = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(0.5 * (H + H.transpose())).eigenvalues();
  return e[0] / std::max(1.0, e[n - 1]);
}

class SecondOrderFrom : public ::testing::TestWithParam<std::tuple<Start, const char*>> {};

TEST_P(SecondOrderFrom, NoRunEndsInAStationaryPointThatIsNotAMinimum) {
  const auto& [start, name] = GetParam();
  const std::vector<std::string> known = backend_names();
  if (std::string(name) == "ceres" && std::find(known.begin(), known.end(), "ceres") == known.end()) GTEST_SKIP() << "no Ceres";
  Options options;
  options.cost_tolerance = 1e-12;
  options.second_order = true;
  const auto backend = make_backend(name, options);
  int left = 0;
  for (int seed = 0; seed < kProblems; ++seed) {
    const Problem problem = ranges(seed, start);
    Values values = problem.start;
    const Summary end = backend->solve(problem.graph, values);
    EXPECT_NE(end.minimum, Minimum::not_checked) << "seed " << seed << ": " << end.not_checked << end.str();
    EXPECT_GT(least_eigenvalue(problem.graph, values), -1e-5) << "seed " << seed << ": " << end.str();
    left += end.saddles_left > 0;
  }
  EXPECT_GE(left, kProblems / 2 - 5);  // the starts of the others, and a first step, may be off the saddle
}

INSTANTIATE_TEST_SUITE_P(EveryStart, SecondOrderFrom,
                         ::testing::Combine(::testing::Values(Start::plane, Start::line, Start::point),
                                            ::testing::Values("irls", "nesterov", "ceres", "gnc-irls")));

TEST(SecondOrder, IsAnOptionOfEveryBackend) {
  const Problem problem = ranges(3, Start::plane);
  Values values = problem.start;
  const Summary off = make_backend("irls")->solve(problem.graph, values);
  EXPECT_EQ(off.minimum, Minimum::not_checked);
  EXPECT_EQ(off.not_checked, "not asked for");
  Options options;
  options.second_order = options.findings = true;
  const Summary on = make_backend("irls", options)->solve(problem.graph, values);
  EXPECT_EQ(on.minimum, Minimum::left_saddle);
  EXPECT_LT(on.cost, off.cost);
  EXPECT_GT(on.seconds_second_order, 0);
  EXPECT_THAT(on.str(), ::testing::HasSubstr("left a saddle, saddles left: "));
  ASSERT_FALSE(on.findings.empty());  // all anchors in one plane
  EXPECT_EQ(on.findings.front().kind, Finding::Kind::mirror_image);
}

TEST(SecondOrder, APoseGraphHasNothingToHide) {
  Graph graph;
  Values values;
  for (int i = 0; i < 2; ++i) values.insert(N(i), Pose2(i, 0, 0));
  graph.add(Prior<Pose2>::from_sigmas(Pose2(0, 0, 0), Vector<3>(1, 1, 1)), {N(0)});
  graph.add(Between<Pose2>::from_sigmas(Pose2(1, 0.5, 0), Vector<3>(1, 1, 1)), {N(0), N(1)});
  Options options;
  options.second_order = true;
  const Summary end = make_backend("irls", options)->solve(graph, values);
  EXPECT_EQ(end.minimum, Minimum::not_checked);
  EXPECT_EQ(end.not_checked, "no factor that could hide a saddle");
}

/// Two robots on one spot, 5 m apart by measurement: cases/pose_on_pose.
TEST(SecondOrder, ZeroDistanceIsLeftUnderEveryBackend) {
  for (const char* name : {"irls", "nesterov"}) {
    Graph graph;
    Values values;
    for (int i = 0; i < 2; ++i) {
      values.insert(N(i), Point2(0, 0));
      graph.add(Prior<Point2>::from_sigmas(Point2(0, 0), Point2::Tangent::Constant(10)), {N(i)});
    }
    graph.add(Range<Point2, Point2>{5, 0.1}, {N(0), N(1)});
    Values stuck = values;
    EXPECT_NEAR(make_backend(name)->solve(graph, stuck).cost, 1250, 1e-9) << name;  // ½ (5 / 0.1)²: the back-end alone says converged
    const SecondOrder end = second_order(graph, values, *make_backend(name));
    EXPECT_EQ(end.verdict, Verdict::left_saddle) << name << ": " << end.str();
    EXPECT_NEAR((values.at<Point2>(N(0)).value - values.at<Point2>(N(1)).value).norm(), 5, 0.01) << name;
    EXPECT_LT(end.summary.cost, 0.13) << name;  // 2 · ½ (2.5 / 10)² · 2 = 0.0625 and the range's own
  }
}

TEST(SecondOrder, AMinimumIsLeftAsItIs) {
  Graph graph;
  Values values;
  values.insert(N(0), Point2(3, 4));
  graph.add(Prior<Point2>::from_sigmas(Point2(1, 2), Point2::Tangent::Constant(1)), {N(0)});
  const SecondOrder end = second_order(graph, values, *make_backend("irls"));
  EXPECT_EQ(end.verdict, Verdict::minimum);
  EXPECT_EQ(end.saddles, 0);
  EXPECT_GT(end.curvature, 0.9);  // 1 / (1 + damping)
}

TEST(SecondOrder, CheckedButNotLeft) {
  const Problem problem = ranges(3, Start::plane);
  Values values = problem.start;
  const SecondOrder end = second_order(problem.graph, values, *make_backend("irls"), {12, 1e-4, 0});
  EXPECT_EQ(end.verdict, Verdict::not_checked);
  EXPECT_NE(end.why.find("max_saddles"), std::string::npos) << end.why;
  EXPECT_LT(end.curvature, -1e-4);
}

TEST(SecondOrder, AnUnfinishedSolveIsNotChecked) {
  Options options;
  options.max_iterations = 1;
  const Problem problem = ranges(0, Start::plane);
  Values values = problem.start;
  const SecondOrder end = second_order(problem.graph, values, *make_backend("irls", options));
  EXPECT_EQ(end.verdict, Verdict::not_checked);
  EXPECT_NE(end.why.find("did not converge"), std::string::npos) << end.why;
}

TEST(SecondOrder, OptionsNameTheirRule) {
  const Problem problem = ranges(0, Start::plane);
  Values values = problem.start;
  const auto backend = make_backend("irls");
  EXPECT_THROW(second_order(problem.graph, values, *backend, {0, 1e-4, 1}), BadOption);
  EXPECT_THROW(second_order(problem.graph, values, *backend, {1, 0, 1}), BadOption);
  EXPECT_THROW(second_order(problem.graph, values, *backend, {1, 1e-4, -1}), BadOption);
}

}  // namespace
}  // namespace holdfast
