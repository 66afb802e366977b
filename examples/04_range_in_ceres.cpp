// One holdfast factor in a user's own ceres::Problem, on the user's own memory: poses as [x y yaw], a beacon as [x y].
#include <ceres/ceres.h>

#include <cmath>
#include <holdfast/adapters/ceres/ceres.hpp>
#include <holdfast/factors/between.hpp>
#include <holdfast/factors/range.hpp>
#include <iostream>

using namespace holdfast;

int main() {
  constexpr int steps = 10;
  double poses[steps][3] = {};  // all at the origin, for a start
  double beacon[2] = {3, 1};    // a bad guess: it stands at (4, 3)
  ceres::Problem problem;
  for (int k = 0; k < steps; ++k) {
    if (k > 0)
      ceres_add<PositionYaw, PositionYaw>(problem, Between<Pose2>::from_sigmas(Pose2(1, 0, 0), Vector<3>(0.01, 0.01, 0.01)), Squared{},
                                          {poses[k - 1], poses[k]});
    const double range = k == 4 ? 20 : std::hypot(4 - k, 3);  // one echo
    ceres_add<PositionYaw, Own<Point2>>(problem, Range<Pose2, Point2>{range, 0.05}, Cauchy{2}, {poses[k], beacon});
  }
  problem.SetParameterBlockConstant(poses[0]);

  ceres::Solver::Options options;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  std::cout << summary.BriefReport() << "\nbeacon at " << beacon[0] << ' ' << beacon[1] << '\n';
  return std::hypot(beacon[0] - 4, beacon[1] - 3) < 0.01 ? 0 : 1;
}
