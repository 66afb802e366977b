// Our range in a stranger's optimizer of g2o.
#include <g2o/core/block_solver.h>
#include <g2o/core/optimization_algorithm_levenberg.h>
#include <g2o/core/sparse_optimizer.h>
#include <g2o/solvers/eigen/linear_solver_eigen.h>
#include <g2o/types/slam2d/vertex_point_xy.h>
#include <g2o/types/slam2d/vertex_se2.h>

#include <cmath>
#include <cstdio>
#include <holdfast/adapters/g2o/g2o.hpp>
#include <holdfast/factors/range.hpp>

using namespace holdfast;

int main() {
  using Solver = g2o::BlockSolverX;
  g2o::SparseOptimizer optimizer;
  optimizer.setAlgorithm(new g2o::OptimizationAlgorithmLevenberg(
      std::make_unique<Solver>(std::make_unique<g2o::LinearSolverEigen<Solver::PoseMatrixType>>())));
  auto* pose = new g2o::VertexSE2;
  pose->setId(0);
  pose->setEstimate(g2o::SE2(0, 0, 0.5));
  pose->setFixed(true);
  auto* beacon = new g2o::VertexPointXY;
  beacon->setId(1);
  beacon->setEstimate({2.5, 0.1});
  optimizer.addVertex(pose);
  optimizer.addVertex(beacon);
  optimizer.addEdge(g2o_edge(Range<Pose2, Point2>{3, 0.1}, {pose, beacon}, Huber{2}));
  optimizer.initializeOptimization();
  optimizer.optimize(20);
  const bool right = std::abs(beacon->estimate().norm() - 3) < 1e-6;
  std::printf("consumer with g2o: %s\n", right ? "ok" : "WRONG");
  return right ? 0 : 1;
}
