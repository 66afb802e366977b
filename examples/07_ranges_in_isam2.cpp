// Ranges in a user's GTSAM graph, solved step by step by iSAM2.
#include <gtsam/inference/Symbol.h>
#include <gtsam/nonlinear/ISAM2.h>
#include <gtsam/slam/BetweenFactor.h>

#include <cmath>
#include <holdfast/adapters/gtsam/gtsam.hpp>
#include <holdfast/factors/range.hpp>
#include <iostream>

using gtsam::symbol_shorthand::L;
using gtsam::symbol_shorthand::X;

int main() {
  const auto step_noise = gtsam::noiseModel::Isotropic::Sigma(3, 0.01);
  gtsam::ISAM2 isam;
  for (int k = 0; k < 20; ++k) {
    gtsam::NonlinearFactorGraph graph;
    gtsam::Values start;
    start.insert(X(k), gtsam::Pose2(k, 0, 0));
    if (k == 0) {
      graph.addPrior(X(0), gtsam::Pose2(), step_noise);
      graph.addPrior(L(0), gtsam::Point2(7, 4), gtsam::noiseModel::Isotropic::Sigma(2, 2.0));  // it stands at (8, 5)
      start.insert(L(0), gtsam::Point2(7, 4));
    } else {
      graph.emplace_shared<gtsam::BetweenFactor<gtsam::Pose2>>(X(k - 1), X(k), gtsam::Pose2(1, 0, 0), step_noise);
    }
    const double range = k == 8 ? 30 : std::hypot(8 - k, 5);  // one echo
    graph.push_back(
        holdfast::gtsam_factor(holdfast::Range<holdfast::Pose2, holdfast::Point2>{range, 0.05}, {X(k), L(0)}, holdfast::Cauchy{2}));
    isam.update(graph, start);
  }
  for (int i = 0; i < 5; ++i) isam.update();
  const gtsam::Point2 landmark = isam.calculateEstimate<gtsam::Point2>(L(0));
  std::cout << "landmark at " << landmark.transpose() << '\n';
  return (landmark - gtsam::Point2(8, 5)).norm() < 0.05 ? 0 : 1;
}
