// Radios: antennas off the body's origin, clocks, differences of arrival.
#include <holdfast/factors/antenna_range.hpp>
#include <holdfast/factors/antenna_range_with_lever.hpp>
#include <holdfast/factors/time_difference.hpp>
#include <holdfast/factors/two_way_range.hpp>

#include "bind_window.hpp"

namespace holdfast::python {

void bind_radio_factors(nb::module_& m) {
  bind_measurement<AntennaRange<Pose2, Point2>>(m);
  bind_measurement<AntennaRange<Pose2, Pose2>>(m);
  bind_measurement<AntennaRange<Pose3, Point3>>(m);
  bind_measurement<AntennaRange<Pose3, Pose3>>(m);
  bind_factor<AntennaRangeWithBias<Pose2, Point2>>(m);
  bind_factor<AntennaRangeWithBias<Pose2, Pose2>>(m);
  bind_factor<AntennaRangeWithBias<Pose3, Point3>>(m);
  bind_factor<AntennaRangeWithBias<Pose3, Pose3>>(m);
  bind_factor<AntennaRangeWithDelays<Pose2, Pose2>>(m);
  bind_factor<AntennaRangeWithDelays<Pose3, Pose3>>(m);
  bind_factor<AntennaRangeWithScale<Pose2, Pose2>>(m);
  bind_factor<AntennaRangeWithScale<Pose3, Pose3>>(m);
  bind_factor<AntennaRangeWithBiasAndScale<Pose2, Pose2>>(m);
  bind_factor<AntennaRangeWithBiasAndScale<Pose3, Pose3>>(m);
  bind_factor<TwoWayRange<Pose2, Pose2>>(m);
  bind_factor<TwoWayRange<Pose3, Pose3>>(m);
  bind_factor<AntennaRangeWithLever<Pose2, Point2>>(m);
  bind_factor<AntennaRangeWithLever<Pose3, Point3>>(m);
  bind_factor<TimeDifference<Pose2, Point2, Point2>>(m);
  bind_factor<TimeDifference<Pose3, Point3, Point3>>(m);
  bind_factor<TimeDifference<Point2, Point2, Point2>>(m);
  bind_factor<TimeDifference<Point3, Point3, Point3>>(m);
  bind_factor<TimeDifferenceWithOffset<Pose2, Point2, Point2>>(m);
  bind_factor<TimeDifferenceWithOffset<Pose3, Point3, Point3>>(m);
  bind_factor<TimeDifferenceWithOffset<Point2, Point2, Point2>>(m);
  bind_factor<TimeDifferenceWithOffset<Point3, Point3, Point3>>(m);
}

}  // namespace holdfast::python
