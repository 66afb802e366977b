// Our range in a stranger's graph of GTSAM.
#include <gtsam/geometry/Pose2.h>
#include <gtsam/inference/Symbol.h>
#include <gtsam/nonlinear/LevenbergMarquardtOptimizer.h>

#include <cmath>
#include <cstdio>
#include <holdfast/adapters/gtsam/gtsam.hpp>
#include <holdfast/factors/range.hpp>

using namespace holdfast;
using gtsam::symbol_shorthand::L;
using gtsam::symbol_shorthand::X;

int main() {
  gtsam::NonlinearFactorGraph graph;
  graph.addPrior(X(0), gtsam::Pose2(0, 0, 0.5), gtsam::noiseModel::Isotropic::Sigma(3, 1e-3));
  graph.addPrior(L(0), gtsam::Point2(2.5, 0), gtsam::noiseModel::Isotropic::Sigma(2, 100));
  graph.push_back(gtsam_factor(Range<Pose2, Point2>{3, 0.1}, {X(0), L(0)}, Huber{2}));
  gtsam::Values start;
  start.insert(X(0), gtsam::Pose2(0.1, 0, 0.5));
  start.insert(L(0), gtsam::Point2(2.5, 0.1));
  const gtsam::Values answer = gtsam::LevenbergMarquardtOptimizer(graph, start).optimize();
  const gtsam::Point2 beacon = answer.at<gtsam::Point2>(L(0));
  const bool right = std::abs(beacon.norm() - 3) < 1e-3;
  std::printf("consumer with GTSAM: %s\n", right ? "ok" : "WRONG");
  return right ? 0 : 1;
}
