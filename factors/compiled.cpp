// The batches of the usual factors (extern template at the end of their headers): compiled once here, for all programs.
#include <holdfast/factors/between.hpp>
#include <holdfast/factors/detail/ball_gradients.hpp>
#include <holdfast/factors/huber_measurement.hpp>
#include <holdfast/factors/position_step.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/relative_point.hpp>
#include <holdfast/factors/von_mises_bearing.hpp>
#include <holdfast/factors/white_acceleration.hpp>
#include <holdfast/graph/graph.hpp>

namespace holdfast {
namespace {

[[maybe_unused]] const bool kBallGradients = detail::enter_ball_gradients();

}  // namespace

template class Batch<Between<Pose2>>;
template class Batch<Between<Pose3>>;
template class Batch<HuberMeasurement<Motion2>>;
template class Batch<PositionStep<Point2, Point2>>;
template class Batch<Prior<Point2>>;
template class Batch<Prior<Point3>>;
template class Batch<Prior<Pose2>>;
template class Batch<Prior<Pose3>>;
template class Batch<Prior<Motion2>>;
template class Batch<Prior<Motion3>>;
template class Batch<Prior<Accel3>>;
template class Batch<RelativePoint<Pose2, Point2>>;
template class Batch<RelativePoint<Pose3, Point3>>;
template class Batch<VonMisesBearingBody<Pose2, Point2>>;
template class Batch<VonMisesBearingBody<Pose3, Point3>>;
template class Batch<WhiteAcceleration<Motion2>>;

}  // namespace holdfast
