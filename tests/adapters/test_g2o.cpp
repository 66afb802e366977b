// Our factors as edges of g2o, and its optimizers as back-ends.
#include <g2o/core/block_solver.h>
#include <g2o/core/optimization_algorithm_levenberg.h>
#include <g2o/core/sparse_optimizer.h>
#include <g2o/solvers/eigen/linear_solver_eigen.h>
#include <gtest/gtest.h>

#include <holdfast/adapters/g2o/backend.hpp>
#include <holdfast/adapters/g2o/g2o.hpp>

#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

constexpr Agent A('A');

/// The Jacobian is with respect to g2o's own oplus.
template <class V>
void expect_tangent() {
  std::mt19937_64 rng(1);
  const auto* slot = holdfast::detail::the_slot<holdfast::detail::G2oSlotOf<V>>();
  for (int i = 0; i < 20; ++i) {
    V x = random_variable<V>(rng);
    for (int c = 0; c < V::dim; ++c) {
      const auto moved = [&](double step) {
        const std::unique_ptr<g2o::OptimizableGraph::Vertex> vertex(slot->make(reinterpret_cast<const double*>(&x)));
        const Eigen::VectorXd update = step * Eigen::VectorXd::Unit(V::dim, c);
        vertex->oplus(update.data());
        return x.local(G2oVariable<V>::ours(dynamic_cast<const typename G2oVariable<V>::Vertex&>(*vertex)));
      };
      EXPECT_LT(((moved(1e-6) - moved(-1e-6)) / 2e-6 - G2oVariable<V>::tangent(x).col(c)).norm(), 1e-7);
    }
  }
}
TEST(G2oVariable, TangentIsG2os) {
  expect_tangent<Pose2>();
  expect_tangent<Pose3>();
  expect_tangent<Point3>();
  expect_tangent<Motion2>();
}

TEST(G2oEdge, ATypedEdgeIsSolvedInAUsersOptimizer) {
  g2o::SparseOptimizer optimizer;
  optimizer.setAlgorithm(new g2o::OptimizationAlgorithmLevenberg(
      std::make_unique<g2o::BlockSolverX>(std::make_unique<g2o::LinearSolverEigen<g2o::BlockSolverX::PoseMatrixType>>())));
  auto* beacon = new g2o::VertexPointXY();
  beacon->setId(0);
  beacon->setEstimate({3, 1});
  optimizer.addVertex(beacon);
  for (int k = 1; k <= 6; ++k) {
    auto* pose = new g2o::VertexSE2();
    pose->setId(k);
    pose->setEstimate(g2o::SE2(k, 0.1 * k * k, 0));
    pose->setFixed(true);
    optimizer.addVertex(pose);
    const double range = k == 3 ? 30 : std::hypot(k - 4, 0.1 * k * k - 3);  // one echo
    ASSERT_TRUE(optimizer.addEdge(g2o_edge(Range<Pose2, Point2>{range, 0.05}, {pose, beacon}, Cauchy{2})));
  }
  optimizer.initializeOptimization();
  optimizer.optimize(100);
  EXPECT_LT((beacon->estimate() - Eigen::Vector2d(4, 3)).norm(), 0.01);
}

TEST(G2oEdge, AVertexOfAnotherClassIsRefused) {
  g2o::VertexSE2 pose;
  g2o::VertexPointXYZ point;
  EXPECT_THROW(g2o_edge(Range<Pose2, Point2>{1, 1}, {&pose, &point}), BadType);
  EXPECT_THROW(g2o_edge(Range<Pose2, Point2>{1, 1}, {&pose}), BadType);
}

template <class Problem>
void expect_same_optimum(const Problem& problem) {
  Values ours = problem.start;
  ASSERT_TRUE(solve("irls", problem.graph, ours).usable());
  for (const char* backend : {"g2o", "g2o-lm"}) {
    SCOPED_TRACE(backend);
    Values theirs = problem.start;
    const Summary summary = solve(backend, problem.graph, theirs);
    ASSERT_TRUE(summary.usable()) << summary.str();
    const double cost = problem.graph.cost(ours);
    EXPECT_NEAR(problem.graph.cost(theirs), cost, 1e-6 * cost);
    EXPECT_NEAR(summary.cost, problem.graph.cost(theirs), 1e-12 * cost);
  }
}

TEST(G2oBackend, ReachesTheSameOptimum) {
  register_g2o_backends();
  expect_same_optimum(slam<Pose2>(3, 12, 0.1, Cauchy{2}, 0.05));
  expect_same_optimum(slam<Pose3>(4, 12, 0.1, per_component(Huber{2}), 0.05));
  auto fixed = slam<Pose3>(5, 10, 0.1, Huber{2}, 0.05);
  fixed.graph.fix(A(0));
  fixed.graph.fix(Key('L', 1));
  expect_same_optimum(fixed);
  expect_same_optimum(tracking<Motion2>(6, 12, 0.1, per_component(Huber{2})));
}

}  // namespace
}  // namespace holdfast::testing
