// Directions.
#include <holdfast/factors/antenna_bearing.hpp>
#include <holdfast/factors/bearing_ray.hpp>
#include <holdfast/factors/range_bearing.hpp>
#include <holdfast/factors/range_bearing_ball.hpp>
#include <holdfast/factors/von_mises_bearing.hpp>

#include "bind_factor.hpp"

namespace holdfast::python {

void bind_bearing_factors(nb::module_& m) {
  bind_factor<BearingRay<Point2, Point2>>(m);
  bind_factor<BearingRay<Point3, Point3>>(m);
  bind_factor<BearingRay<Pose2, Point2>>(m);
  bind_factor<BearingRay<Pose3, Point3>>(m);
  bind_factor<RangeBearing<Point2, Point2>>(m);
  bind_factor<RangeBearing<Point3, Point3>>(m);
  bind_factor<RangeBearing<Pose2, Point2>>(m);
  bind_factor<RangeBearing<Pose3, Point3>>(m);
  bind_factor<RangeBearingBall<Point2, Point2>>(m);
  bind_factor<RangeBearingBall<Point3, Point3>>(m);
  bind_factor<RangeBearingBall<Pose2, Point2>>(m);
  bind_factor<RangeBearingBall<Pose3, Point3>>(m);
  bind_factor<VonMisesBearing<Point2, Point2>>(m);
  bind_factor<VonMisesBearing<Point3, Point3>>(m);
  bind_factor<VonMisesBearing<Pose2, Point2>>(m);
  bind_factor<VonMisesBearing<Pose3, Point3>>(m);
  bind_factor<VonMisesBearingBody<Pose2, Point2>>(m);
  bind_factor<VonMisesBearingBody<Pose2, Pose2>>(m);
  bind_factor<VonMisesBearingBody<Pose3, Point3>>(m);
  bind_factor<VonMisesBearingBody<Pose3, Pose3>>(m);
  bind_factor<AntennaBearing<Pose2, Point2>>(m);
  bind_factor<AntennaBearing<Pose2, Pose2>>(m);
  bind_factor<AntennaBearing<Pose3, Point3>>(m);
  bind_factor<AntennaBearing<Pose3, Pose3>>(m);
  bind_factor<AntennaBearingBody<Pose2, Point2>>(m);
  bind_factor<AntennaBearingBody<Pose2, Pose2>>(m);
  bind_factor<AntennaBearingBody<Pose3, Point3>>(m);
  bind_factor<AntennaBearingBody<Pose3, Pose3>>(m);
}

}  // namespace holdfast::python
