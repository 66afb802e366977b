// Our range in a stranger's ceres::Problem.
#include <ceres/ceres.h>

#include <cmath>
#include <cstdio>
#include <holdfast/adapters/ceres/ceres.hpp>
#include <holdfast/factors/range.hpp>

using namespace holdfast;

int main() {
  double pose[3] = {0, 0, 0.5}, beacon[2] = {2.5, 0.1};
  ceres::Problem problem;
  ceres_add<PositionYaw, Own<Point2>>(problem, Range<Pose2, Point2>{3, 0.1}, Huber{2}, {pose, beacon});
  problem.SetParameterBlockConstant(pose);
  ceres::Solver::Options options;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  const bool right = std::abs(std::hypot(beacon[0], beacon[1]) - 3) < 1e-6;
  std::printf("consumer with Ceres: %s\n", right ? "ok" : "WRONG");
  return right ? 0 : 1;
}
