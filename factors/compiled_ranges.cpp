// The batches of the usual ranges (extern template at the end of their headers): compiled once here, for all programs.
#include <holdfast/factors/detail/ball_gradients.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/graph/graph.hpp>

namespace holdfast {
namespace {

[[maybe_unused]] const bool kBallGradients = detail::enter_ball_gradients();

}  // namespace

template class Batch<Range<Point2, Point2>>;
template class Batch<Range<Pose2, Point2>>;
template class Batch<Range<Pose2, Pose2>>;
template class Batch<Range<Pose3, Pose3>>;
template class Batch<Range<Motion2, Point2>>;
template class Batch<Range<Motion2, Motion2>>;
template class Batch<Range<Pose3, Point3>>;
template class Batch<RangeBall<Point2, Point2>>;
template class Batch<RangeBall<Point3, Point3>>;
template class Batch<RangeBall<Pose2, Point2>>;
template class Batch<RangeBall<Pose2, Pose2>>;
template class Batch<RangeBall<Pose3, Pose3>>;
template class Batch<RangeBall<Motion2, Point2>>;
template class Batch<RangeBall<Motion2, Motion2>>;
template class Batch<RangeBall<Pose3, Point3>>;

}  // namespace holdfast
