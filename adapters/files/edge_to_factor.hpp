// The one place where an edge of a file becomes a factor.
//
//   edge_to_factor(edge.measurement, values, [&](const auto& factor, auto... keys) {
//     return graph.add(factor, {keys...}, loss);       // or window.add: the caller says what it is added to, and under which loss
//   });
#pragma once

#include <holdfast/factors/between.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/factors/relative_point.hpp>
#include <holdfast/factors/von_mises_bearing.hpp>
#include <holdfast/graph/files/dataset.hpp>
#include <holdfast/graph/values.hpp>

namespace holdfast {

/// Pose2 for Point2, Pose3 for Point3.
template <class P>
using PoseFor = std::conditional_t<P::dim == 2, Pose2, Pose3>;

template <class V>
Between<V> to_factor(const RelativePoseEdge<V>& edge) {
  return Between<V>::from_information(edge.measured, edge.information());
}
template <class P>
RelativePoint<PoseFor<P>, P> to_factor(const RelativePointEdge<P>& edge) {
  return RelativePoint<PoseFor<P>, P>::from_information(edge.measured.value, edge.information());
}
template <class V>
Prior<V> to_factor(const PriorEdge<V>& edge) {
  return Prior<V>::from_information(edge.measured, edge.information());
}

/// A prior on the pose that says nothing of the rotation: in Prior's tangent the translation is in the world.
template <class P>
Prior<PoseFor<P>> to_factor(const PositionEdge<P>& edge) {
  constexpr int space = P::dim;
  PoseFor<P> mean;
  mean.p = edge.measured.value;
  Matrix<PoseFor<P>::dim, PoseFor<P>::dim> information = Matrix<PoseFor<P>::dim, PoseFor<P>::dim>::Zero();
  information.template topLeftCorner<space, space>() = edge.information();
  return Prior<PoseFor<P>>::from_information(mean, information);
}
inline VonMisesBearingBody<Pose2, Point2> to_factor(const BearingEdge& edge) {
  return {Vector<2>(std::cos(edge.angle), std::sin(edge.angle)), edge.information};
}

/// Calls add(factor, keys…) with the factor of the edge, and returns what it returns: the same type for every factor.
/// A range does not say what lies at its ends: `values` do. Throws BadKey where they have one of its keys not, or as something that is
/// neither a pose nor a point; BadType where one end lies in the plane, the other in space; what from_information throws.
template <class V, class Add>
auto edge_to_factor(const RelativePoseEdge<V>& edge, const Values&, Add&& add) {
  return add(to_factor(edge), edge.first, edge.second);
}
template <class P, class Add>
auto edge_to_factor(const RelativePointEdge<P>& edge, const Values&, Add&& add) {
  return add(to_factor(edge), edge.pose, edge.landmark);
}
template <class V, class Add>
auto edge_to_factor(const PriorEdge<V>& edge, const Values&, Add&& add) {
  return add(to_factor(edge), edge.key);
}
template <class P, class Add>
auto edge_to_factor(const PositionEdge<P>& edge, const Values&, Add&& add) {
  return add(to_factor(edge), edge.key);
}
template <class Add>
auto edge_to_factor(const BearingEdge& edge, const Values&, Add&& add) {
  return add(to_factor(edge), edge.pose, edge.landmark);
}

namespace detail {
/// What a range names, as `values` have it.
struct RangeEnds {
  bool in_plane;
  bool first_is_pose, second_is_pose;
};
RangeEnds range_ends(const RangeEdge& edge, const Values& values);

template <class Pose, class Point, class Add>
auto range_to_factor(const RangeEdge& edge, const RangeEnds& ends, Add&& add) {
  const auto with = [&](auto range) {
    range.distance = edge.distance;
    range.sigma = std::sqrt(edge.variance);
    return add(range, edge.first, edge.second);
  };
  if (ends.first_is_pose && ends.second_is_pose) return with(Range<Pose, Pose>{});
  if (ends.first_is_pose) return with(Range<Pose, Point>{});
  if (ends.second_is_pose) return with(Range<Point, Pose>{});
  return with(Range<Point, Point>{});
}
}  // namespace detail

template <class Add>
auto edge_to_factor(const RangeEdge& edge, const Values& values, Add&& add) {
  const detail::RangeEnds ends = detail::range_ends(edge, values);
  return ends.in_plane ? detail::range_to_factor<Pose2, Point2>(edge, ends, add) : detail::range_to_factor<Pose3, Point3>(edge, ends, add);
}
template <class Add>
auto edge_to_factor(const Measurement& measurement, const Values& values, Add&& add) {
  return std::visit([&](const auto& edge) { return edge_to_factor(edge, values, add); }, measurement);
}

}  // namespace holdfast
