// The convex relaxation of a range: a distance is an upper bound.   r = (x − y) / sigma,   x = p_b − p_a,   y = P_ball(distance)(x)
//
// Paper C (4)–(6): ½‖r‖² = ½ max(0, ‖x‖ − distance)²/σ² is the least ½ ‖x − y‖²/σ² over the ball ‖y‖ ≤ distance, i.e. the squared
// distance to the ball. As a vector, r has the curvature across the range that its length alone has not: with one component instead, JᵀJ
// leaves a swarm free to turn about its anchors, and second-order back-ends stop far above the minimum. Components are along the axes of
// the world: give it block losses. A and B: anything with a position. Inside the ball residual and Jacobian are zero.
//
// hessian(): by x it is ((1 − d/n) I + (d/n) u uᵀ)/σ² outside, with n = ‖x‖, u = x/n and d the distance, and 0 inside. JᵀJ has (1 − d/n)²
// in place of (1 − d/n): near the ball it sees almost nothing of what lies across the range.
#pragma once

#include <holdfast/factors/detail/displacement.hpp>
#include <holdfast/graph/batch.hpp>
#include <holdfast/graph/require.hpp>
#include <holdfast/graph/variables.hpp>

namespace holdfast {

namespace detail {

/// The residual by x = p_b − p_a and, where D is given, its derivative by x.
template <int N>
Vector<N> range_ball(const Vector<N>& x, double distance, double sigma, Matrix<N, N>* D) {
  const auto norm = safe_norm(x);
  if (norm.value <= distance) {  // false for NaN, which so reaches the residual
    if (D != nullptr) D->setZero();
    return Vector<N>::Zero();
  }
  const double outside = 1 - distance / norm.value;  // of x, this part
  if (D != nullptr) *D = (outside * Matrix<N, N>::Identity() + (1 - outside) * norm.gradient * norm.gradient.transpose()) / sigma;
  return outside / sigma * x;
}

/// Its hessian() by x.
template <int N>
Matrix<N, N> range_ball_hessian(const Vector<N>& x, double distance, double sigma) {
  if (safe_norm(x).value <= distance) return Matrix<N, N>::Zero();
  return ball_hessian(x, distance) / (sigma * sigma);
}

}  // namespace detail

template <class A, class B>
struct RangeBall {
  double distance;  ///< [m]
  double sigma;     ///< [m]

  using Variables = variables<A, B>;
  static constexpr int residual_dim = space_dim<A>;
  static constexpr bool is_convex = true;  // for poses, too: the position is linear in every tangent
  static const char* name() { return "RangeBall"; }
  static constexpr auto fields() { return std::tuple(field("distance", &RangeBall::distance), field("sigma", &RangeBall::sigma)); }

  Vector<residual_dim> operator()(const A& a, const B& b, Jacobians<RangeBall>* J = nullptr) const {
    Matrix<residual_dim, residual_dim> D;
    const Vector<residual_dim> r = detail::range_ball<residual_dim>(displacement(a, b), distance, sigma, J == nullptr ? nullptr : &D);
    if (J != nullptr) set_displacement_jacobian(D, *J);
    return r;
  }

  Matrix<Variables::total_dim, Variables::total_dim> hessian(const A& a, const B& b) const {
    return displacement_hessian<A, B>(detail::range_ball_hessian<residual_dim>(displacement(a, b), distance, sigma));
  }

  Vector<residual_dim> raw(const Vector<residual_dim>& r) const { return sigma * r; }  ///< [m]
  void validate() const {
    require_not_negative("RangeBall.distance", distance);
    require_positive("RangeBall.sigma", sigma);
  }
};

// Compiled into the library (factors/compiled_ranges.cpp), not anew by whoever adds them to a graph.
extern template class Batch<RangeBall<Point2, Point2>>;
extern template class Batch<RangeBall<Point3, Point3>>;
extern template class Batch<RangeBall<Pose2, Point2>>;
extern template class Batch<RangeBall<Pose2, Pose2>>;
extern template class Batch<RangeBall<Pose3, Pose3>>;
extern template class Batch<RangeBall<Motion2, Point2>>;
extern template class Batch<RangeBall<Motion2, Motion2>>;
extern template class Batch<RangeBall<Pose3, Point3>>;

}  // namespace holdfast
