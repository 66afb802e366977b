// The pools of the library's own variable types (extern template in values.hpp): compiled once here, for all programs.
#include <holdfast/graph/values.hpp>

namespace holdfast {

template class Pool<Point2>;
template class Pool<Point3>;
template class Pool<Pose2>;
template class Pool<Pose3>;
template class Pool<Motion2>;
template class Pool<Motion3>;
template class Pool<Accel2>;
template class Pool<Accel3>;
template class Pool<Turning2>;
template class Pool<Scalar>;

}  // namespace holdfast
