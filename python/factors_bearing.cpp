// Directions.
#include <holdfast/factors/antenna_bearing.hpp>
#include <holdfast/factors/bearing_ray.hpp>
#include <holdfast/factors/range_bearing.hpp>
#include <holdfast/factors/range_bearing_ball.hpp>
#include <holdfast/factors/von_mises_bearing.hpp>

#include "bind_window.hpp"

namespace holdfast::python {

void bind_bearing_factors(nb::module_& m) {
  bind_measurement<BearingRay<Point2, Point2>>(m);
  bind_measurement<BearingRay<Point3, Point3>>(m);
  bind_measurement<BearingRay<Pose2, Point2>>(m);
  bind_measurement<BearingRay<Pose3, Point3>>(m);
  bind_measurement<RangeBearing<Point2, Point2>>(m);
  bind_measurement<RangeBearing<Point3, Point3>>(m);
  bind_measurement<RangeBearing<Pose2, Point2>>(m);
  bind_measurement<RangeBearing<Pose3, Point3>>(m);
  bind_measurement<RangeBearingBall<Point2, Point2>>(m);
  bind_measurement<RangeBearingBall<Point3, Point3>>(m);
  bind_measurement<RangeBearingBall<Pose2, Point2>>(m);
  bind_measurement<RangeBearingBall<Pose3, Point3>>(m);
  bind_measurement<VonMisesBearing<Point2, Point2>>(m);
  bind_measurement<VonMisesBearing<Point3, Point3>>(m);
  bind_measurement<VonMisesBearing<Pose2, Point2>>(m);
  bind_measurement<VonMisesBearing<Pose3, Point3>>(m);
  bind_measurement<VonMisesBearingBody<Pose2, Point2>>(m);
  bind_measurement<VonMisesBearingBody<Pose2, Pose2>>(m);
  bind_measurement<VonMisesBearingBody<Pose3, Point3>>(m);
  bind_measurement<VonMisesBearingBody<Pose3, Pose3>>(m);
  bind_measurement<AntennaBearing<Pose2, Point2>>(m);
  bind_measurement<AntennaBearing<Pose2, Pose2>>(m);
  bind_measurement<AntennaBearing<Pose3, Point3>>(m);
  bind_measurement<AntennaBearing<Pose3, Pose3>>(m);
  bind_measurement<AntennaBearingBody<Pose2, Point2>>(m);
  bind_measurement<AntennaBearingBody<Pose2, Pose2>>(m);
  bind_measurement<AntennaBearingBody<Pose3, Point3>>(m);
  bind_measurement<AntennaBearingBody<Pose3, Pose3>>(m);
}

}  // namespace holdfast::python
