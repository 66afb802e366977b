// The same graph as a ceres::Problem: what test_backends_every_factor.cpp leaves open.
#include <ceres/version.h>
#include <gtest/gtest.h>

#if CERES_VERSION_MAJOR == 2 && CERES_VERSION_MINOR < 3
#define HOLDFAST_CERES_LOGS_BY_GLOG 1  // later ones log by Abseil
#include <glog/logging.h>
#endif

#include <holdfast/solvers/ceres/ceres.hpp>

#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

void expect_ceres_sees_the_same(const Graph& graph, const Values& values) {
  const CeresEvaluation ceres = evaluate_with_ceres(graph, values);
  const Gradient ours = gradient(graph, values);
  const double cost = graph.cost(values), largest = max_gradient(graph, values);
  EXPECT_NEAR(ceres.cost, cost, 1e-10 * cost);
  ASSERT_EQ(ceres.gradient.size(), ours.value.size());
  for (std::size_t i = 0; i < ours.value.size(); ++i) EXPECT_NEAR(ceres.gradient[i], ours.value[i], 1e-10 * largest) << i;
}

TEST(Ceres, SeesTheSameCostAndGradientOfWholeGraphs) {
  for (const std::uint64_t seed : {1, 2, 3})
    for (int kind = 0; kind < kLossKinds; ++kind)
      for (const Loss& loss : {default_loss(kind), per_component(default_loss(kind)), one_sided(per_component(default_loss(kind)))}) {
        SCOPED_TRACE(loss.str());
        auto plane = slam<Pose2>(seed, 8, 0.5, loss, 0.5);
        expect_ceres_sees_the_same(plane.graph, plane.start);
        plane.graph.fix(Key('A', 0));
        plane.graph.fix(Key('L', 1));
        expect_ceres_sees_the_same(plane.graph, plane.start);
        const auto space = slam<Pose3>(seed, 6, 0.5, loss, 0.5);
        expect_ceres_sees_the_same(space.graph, space.start);
      }
}

TEST(Ceres, CountsWhatOnlyFixedVariablesCost) {
  auto problem = slam<Pose2>(4, 6, 0.5);
  for (int i = 0; i < 4; ++i) problem.graph.fix(Key('A', i));
  Values values = problem.start;
  const Summary summary = solve("ceres", problem.graph, values);
  EXPECT_NEAR(summary.cost_first, problem.graph.cost(problem.start), 1e-12 * summary.cost_first);
  EXPECT_NEAR(summary.cost, problem.graph.cost(values), 1e-12 * summary.cost);
}

// Ceres warns of a singular matrix. The log is the program's: its level stays as the program set it, and then holds.
TEST(Ceres, LeavesTheLevelOfTheLogToTheProgram) {
#ifndef HOLDFAST_CERES_LOGS_BY_GLOG
  GTEST_SKIP() << "Ceres " << CERES_VERSION_STRING << " logs by Abseil";
#else
  Graph graph;
  graph.add(Between<Point2>::from_sigmas(Point2(1, 0), Vector<2>(0.1, 0.1)), {Key('A', 0), Key('A', 1)});
  Values values;
  values.insert(Key('A', 0), Point2(0, 0));
  values.insert(Key('A', 1), Point2(0, 1));
  const int level = FLAGS_minloglevel;
  for (const int chosen : {google::GLOG_ERROR, google::GLOG_FATAL}) {
    FLAGS_minloglevel = chosen;
    ::testing::internal::CaptureStderr();
    solve("ceres", graph, values);
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
    EXPECT_EQ(FLAGS_minloglevel, chosen);
  }
  FLAGS_minloglevel = level;
#endif
}

TEST(Ceres, VariantsDifferInTheWayNotInTheEnd) {
  const auto problem = slam<Pose3>(5, 15, 0.1, Huber{2}, 0.1);
  for (const CeresVariant& variant : kCeresVariants) {
    Values values = problem.start, reference = problem.start;
    const auto backend = make_ceres(variant, to_the_bottom());
    EXPECT_EQ(backend->name(), variant.name);
    ASSERT_TRUE(backend->solve(problem.graph, values).usable());
    solve("irls", problem.graph, reference);
    EXPECT_NEAR(problem.graph.cost(values), problem.graph.cost(reference), 1e-7 * problem.graph.cost(reference)) << variant.name;
  }
}

}  // namespace
}  // namespace holdfast::testing
