// A measured distance between two positions:   r = (‖p_a − p_b‖ − distance) / sigma          (paper C, eq. 2)
//
// A and B: anything with a position. Where both positions coincide (below kZeroDistance) the residual is its value at 0 and the
// Jacobian is zero, and so is the Hessian.
//
// hessian(): by x = p_b − p_a it is ((1 − d/n) I + (d/n) u uᵀ)/σ², n = ‖x‖, u = x/n, d the distance. It is exact, and INDEFINITE where the
// positions are nearer than measured (n < d): the cost is not convex there.
#pragma once

#include <holdfast/factors/range_ball.hpp>
#include <holdfast/graph/batch.hpp>
#include <holdfast/graph/variables.hpp>

namespace holdfast {

template <class A, class B>
struct Range {
  double distance;  ///< [m]
  double sigma;     ///< [m]

  using Variables = variables<A, B>;
  static constexpr int residual_dim = 1;
  static const char* name() { return "Range"; }
  static constexpr auto fields() { return std::tuple(field("distance", &Range::distance), field("sigma", &Range::sigma)); }

  Vector<1> operator()(const A& a, const B& b, Jacobians<Range>* J = nullptr) const {
    const auto norm = safe_norm(displacement(a, b));
    if (J != nullptr) set_displacement_jacobian(norm.gradient.transpose() / sigma, *J);
    return Vector<1>((norm.value - distance) / sigma);
  }

  Matrix<Variables::total_dim, Variables::total_dim> hessian(const A& a, const B& b) const {
    const Vector<space_dim<A>> x = displacement(a, b);
    if (safe_norm(x).value == 0) return Matrix<Variables::total_dim, Variables::total_dim>::Zero();
    return displacement_hessian<A, B>(ball_hessian(x, distance) / (sigma * sigma));
  }

  RangeBall<A, B> relaxed() const { return {distance, sigma}; }

  Vector<1> raw(const Vector<1>& r) const { return sigma * r; }  ///< [m]
  void validate() const {
    require_not_negative("Range.distance", distance);
    require_positive("Range.sigma", sigma);
  }
};

// Compiled into the library (factors/compiled_ranges.cpp), not anew by whoever adds them to a graph.
extern template class Batch<Range<Point2, Point2>>;
extern template class Batch<Range<Pose2, Point2>>;
extern template class Batch<Range<Pose2, Pose2>>;
extern template class Batch<Range<Pose3, Pose3>>;
extern template class Batch<Range<Motion2, Point2>>;
extern template class Batch<Range<Motion2, Motion2>>;
extern template class Batch<Range<Pose3, Point3>>;

}  // namespace holdfast
