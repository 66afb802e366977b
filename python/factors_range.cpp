// Ranges, and what is known of a range that is missing.
#include <holdfast/factors/missing_distance.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/factors/range_ball.hpp>
#include <holdfast/factors/range_time_offset.hpp>

#include "bind_window.hpp"

namespace holdfast::python {

namespace {

template <class A, class B>
void bind_range(nb::module_& m) {
  auto c = bind_factor<Range<A, B>>(m);
  bind_stream_with_missing<MissingDistance<A, B>>(c);
}

}  // namespace

void bind_range_factors(nb::module_& m) {
  bind_range<Pose2, Point2>(m);
  bind_range<Pose2, Pose2>(m);
  bind_range<Point2, Point2>(m);
  bind_range<Motion2, Point2>(m);
  bind_range<Motion2, Motion2>(m);
  bind_measurement<Range<Accel2, Point2>>(m);
  bind_range<Pose3, Point3>(m);
  bind_range<Pose3, Pose3>(m);
  bind_range<Point3, Point3>(m);
  bind_range<Motion3, Point3>(m);
  bind_range<Motion3, Motion3>(m);
  bind_measurement<RangeBall<Pose2, Point2>>(m);
  bind_measurement<RangeBall<Pose2, Pose2>>(m);
  bind_measurement<RangeBall<Point2, Point2>>(m);
  bind_measurement<RangeBall<Motion2, Point2>>(m);
  bind_measurement<RangeBall<Motion2, Motion2>>(m);
  bind_measurement<RangeBall<Pose3, Point3>>(m);
  bind_measurement<RangeBall<Pose3, Pose3>>(m);
  bind_measurement<RangeBall<Point3, Point3>>(m);
  bind_measurement<RangeBall<Motion3, Point3>>(m);
  bind_measurement<RangeBall<Motion3, Motion3>>(m);
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
