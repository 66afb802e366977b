#include <holdfast/adapters/files/edge_to_factor.hpp>
#include <holdfast/adapters/files/vertex_value.hpp>

namespace holdfast::detail {
namespace {

struct EndType {
  bool in_plane, is_pose;
};

EndType end_type(Key key, const Values& values) {
  const std::optional<VertexValue> value = vertex_value(values, key);
  if (!value) fail<BadType>("a range ends at ", key, ", a ", type_name(values, key), "; files have ranges between poses and points");
  return std::visit(
      [](const auto& v) {
        using V = std::decay_t<decltype(v)>;
        return EndType{V::space_dim == 2, V::dim > V::space_dim};
      },
      *value);
}

}  // namespace

RangeEnds range_ends(const RangeEdge& edge, const Values& values) {
  const EndType first = end_type(edge.first, values), second = end_type(edge.second, values);
  if (first.in_plane != second.in_plane)
    fail<BadType>("a range goes from ", edge.first, ", a ", type_name(values, edge.first), ", to ", edge.second, ", a ",
                  type_name(values, edge.second), "; both ends must be in the plane, or both in space");
  return {first.in_plane, first.is_pose, second.is_pose};
}

}  // namespace holdfast::detail
