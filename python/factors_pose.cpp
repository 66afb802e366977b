// Priors, relative poses and relative points.
#include <holdfast/factors/between.hpp>
#include <holdfast/factors/position_step.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/relative_point.hpp>

#include "bind_window.hpp"

namespace holdfast::python {

void bind_pose_factors(nb::module_& m) {
  bind_factor<Prior<Point2>>(m);
  bind_factor<Prior<Point3>>(m);
  bind_factor<Prior<Pose2>>(m);
  bind_factor<Prior<Pose3>>(m);
  bind_factor<Prior<Motion2>>(m);
  bind_factor<Prior<Motion3>>(m);
  bind_factor<Prior<Accel2>>(m);
  bind_factor<Prior<Accel3>>(m);
  bind_factor<Prior<Scalar>>(m);
  bind_factor<Prior<Turning2>>(m);
  auto between2 = bind_factor<Between<Pose2>>(m);
  auto between3 = bind_factor<Between<Pose3>>(m);
  bind_odometry(between2);
  bind_odometry(between3);
  bind_factor<Between<Point2>>(m);
  bind_factor<Between<Point3>>(m);
  bind_factor<Between<Scalar>>(m);
  bind_measurement<RelativePoint<Pose2, Point2>>(m);
  bind_measurement<RelativePoint<Pose3, Point3>>(m);
  bind_measurement<RelativePoint<Pose2, Pose2>>(m);
  bind_measurement<RelativePoint<Pose3, Pose3>>(m);
  bind_factor<PositionStep<Point2, Point2>>(m);
  bind_factor<PositionStep<Point3, Point3>>(m);
}

}  // namespace holdfast::python
