#include <holdfast/adapters/files/vertex_value.hpp>

namespace holdfast {
namespace {

template <class V>
bool take(const Values& values, Key key, std::optional<VertexValue>& value) {
  if (values.contains<V>(key)) value = values.at<V>(key);
  return value.has_value();
}

}  // namespace

std::optional<VertexValue> vertex_value(const Values& values, Key key) {
  values.slot(key);  // throws where there is none
  std::optional<VertexValue> value;
  take<Pose2>(values, key, value) || take<Pose3>(values, key, value) || take<Point2>(values, key, value) ||
      take<Point3>(values, key, value);
  return value;
}

const char* type_name(const Values& values, Key key) { return values.pool(values.slot(key).pool).type_name(); }

}  // namespace holdfast
