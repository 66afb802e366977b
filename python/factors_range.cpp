// Ranges, and what is known of a range that is missing.
#include <holdfast/factors/missing_distance.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/factors/range_ball.hpp>
#include <holdfast/factors/range_time_offset.hpp>

#include "bind_factor.hpp"

namespace holdfast::python {

void bind_range_factors(nb::module_& m) {
  bind_factor<Range<Pose2, Point2>>(m);
  bind_factor<Range<Pose2, Pose2>>(m);
  bind_factor<Range<Point2, Point2>>(m);
  bind_factor<Range<Motion2, Point2>>(m);
  bind_factor<Range<Motion2, Motion2>>(m);
  bind_factor<Range<Accel2, Point2>>(m);
  bind_factor<Range<Pose3, Point3>>(m);
  bind_factor<Range<Pose3, Pose3>>(m);
  bind_factor<Range<Point3, Point3>>(m);
  bind_factor<Range<Motion3, Point3>>(m);
  bind_factor<Range<Motion3, Motion3>>(m);
  bind_factor<RangeBall<Pose2, Point2>>(m);
  bind_factor<RangeBall<Pose2, Pose2>>(m);
  bind_factor<RangeBall<Point2, Point2>>(m);
  bind_factor<RangeBall<Motion2, Point2>>(m);
  bind_factor<RangeBall<Motion2, Motion2>>(m);
  bind_factor<RangeBall<Pose3, Point3>>(m);
  bind_factor<RangeBall<Pose3, Pose3>>(m);
  bind_factor<RangeBall<Point3, Point3>>(m);
  bind_factor<RangeBall<Motion3, Point3>>(m);
  bind_factor<RangeBall<Motion3, Motion3>>(m);
  bind_factor<MissingDistance<Pose2, Point2>>(m);
  bind_factor<MissingDistance<Pose2, Pose2>>(m);
  bind_factor<MissingDistance<Point2, Point2>>(m);
  bind_factor<MissingDistance<Motion2, Point2>>(m);
  bind_factor<MissingDistance<Motion2, Motion2>>(m);
  bind_factor<MissingDistance<Pose3, Point3>>(m);
  bind_factor<MissingDistance<Pose3, Pose3>>(m);
  bind_factor<MissingDistance<Point3, Point3>>(m);
  bind_factor<MissingDistance<Motion3, Point3>>(m);
  bind_factor<MissingDistance<Motion3, Motion3>>(m);
  bind_factor<MissingDistancePrior>(m);
  bind_factor<MissingDistanceBall<Point2, Point2>>(m);
  bind_factor<MissingDistanceBall<Motion2, Point2>>(m);
  bind_factor<MissingDistanceBall<Pose2, Point2>>(m);
  bind_factor<MissingDistanceBall<Point3, Point3>>(m);
  bind_factor<RangeWithTimeOffset<Motion2, Point2>>(m);
  bind_factor<RangeWithTimeOffset<Motion3, Point3>>(m);
  bind_factor<AntennaRangeWithTimeOffset<Pose2, Point2>>(m);
  bind_factor<AntennaRangeWithTimeOffset<Pose3, Point3>>(m);
}

}  // namespace holdfast::python
