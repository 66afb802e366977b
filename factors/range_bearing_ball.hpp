// The joint convex relaxation of a range and a bearing of the same edge (paper C, eq. 5–7), its auxiliary vector eliminated.
//
// With x = p_b − p_a, distance d, range sigma σ, direction u (unit, world frame, from a to b) and concentration κ the cost is
//   c(x) = min over ‖y‖ ≤ d of  ½ ‖x − y‖²/σ² + κ (1 − uᵀy/d),     attained at  y = P_ball(d)(v),  v = x + α u,  α = σ² κ/d.
// c is convex (a partial minimum of a jointly convex function), once differentiable, ≥ 0, and 0 only at x = d u.
//
// As a residual: put m = [(x − y)/σ ; √κ (u − y/d)]. Since κ (1 − uᵀy/d) = ½ κ ‖u − y/d‖² + ½ κ (1 − ‖y‖²/d²),
//   2c = ‖m‖² + κ (1 − ‖y‖²/d²),       hence   r = g m,   g² = 1 + κ (1 − ‖y‖²/d²)/‖m‖²,   has ½‖r‖² = c.
//   ‖v‖ > d:  y = d v/‖v‖, g = 1.   This is where the optimum is: v = (d + α) u there.
//   ‖v‖ ≤ d:  y = v, x − y = −α u, so ‖m‖ ≥ α/σ > 0 and g ≥ 1: the root never comes near zero. g = 1 on the border.
// Hessian of c: y is where the minimum is attained, so that dc/dx = (x − y)/σ² and d²c/dx² = (1 − dy/dx)/σ², which is
//   ((1 − d/n) I + (d/n) w wᵀ)/σ² with n = ‖v‖, w = v/n outside (‖v‖ > d), and 0 inside: c is linear there.
// So r is continuous, and smooth on either side of the border; no distance is singular, not even zero.
#pragma once

#include <holdfast/factors/detail/displacement.hpp>
#include <holdfast/factors/detail/rules.hpp>
#include <holdfast/factors/range_ball.hpp>

namespace holdfast {

namespace detail {

/// The residual by x = p_b − p_a and, where D is given, its derivative by x.
template <int N>
Vector<2 * N> range_bearing_ball(const Vector<N>& x, double distance, double sigma, const Vector<N>& direction, double kappa,
                                 Matrix<2 * N, N>* D) {
  using Square = Matrix<N, N>;
  const double root = std::sqrt(kappa);
  const Vector<N> v = x + (sigma * sigma * kappa / distance) * direction;
  const double length = v.norm();
  const bool inside = length <= distance;
  const Vector<N> y = inside ? v : Vector<N>(v * (distance / length));

  Vector<2 * N> r;  // m until scaled by g
  r.template head<N>() = (x - y) / sigma;
  r.template tail<N>() = root * (direction - y / distance);
  if (!inside) {
    if (D != nullptr) {
      const Square dy = (Square::Identity() - v * v.transpose() / (length * length)) * (distance / length);
      D->template topRows<N>() = (Square::Identity() - dy) / sigma;
      D->template bottomRows<N>() = -root / distance * dy;
    }
    return r;
  }
  const double m2 = r.squaredNorm();
  const double g = std::sqrt(1 + kappa * (1 - (y / distance).squaredNorm()) / m2);
  if (D != nullptr) {  // d(2c) = −2κ/d uᵀdx and d‖m‖² = −2κ/d (u − y/d)ᵀdx, hence dg = (d(2c) − g² d‖m‖²) / (2 g ‖m‖²)
    const Vector<N> dg = -kappa / (distance * g * m2) * (direction - g * g * (direction - y / distance));
    *D = r * dg.transpose();
    D->template bottomRows<N>().diagonal().array() -= g * root / distance;
  }
  return g * r;
}

}  // namespace detail

template <class A, class B>
struct RangeBearingBall {
  static constexpr int space = space_dim<A>;
  static constexpr int residual_dim = 2 * space;
  using Direction = Vector<space>;
  double distance;      ///< [m], > 0
  double sigma;         ///< [m]
  Direction direction;  ///< unit vector from a to b, world frame
  double kappa;         ///< concentration [1]

  using Variables = variables<A, B>;
  static constexpr bool is_convex = true;  // the cost ½‖r‖², not every component of r
  static const char* name() { return "RangeBearingBall"; }
  static constexpr auto fields() {
    return std::tuple(field("distance", &RangeBearingBall::distance), field("sigma", &RangeBearingBall::sigma),
                      field("direction", &RangeBearingBall::direction), field("kappa", &RangeBearingBall::kappa));
  }

  Vector<residual_dim> operator()(const A& a, const B& b, Jacobians<RangeBearingBall>* J = nullptr) const {
    Matrix<residual_dim, space> D;
    const Vector<residual_dim> r =
        detail::range_bearing_ball<space>(displacement(a, b), distance, sigma, direction, kappa, J == nullptr ? nullptr : &D);
    if (J != nullptr) set_displacement_jacobian(D, *J);
    return r;
  }

  Matrix<Variables::total_dim, Variables::total_dim> hessian(const A& a, const B& b) const {
    const Direction v = displacement(a, b) + (sigma * sigma * kappa / distance) * direction;
    return displacement_hessian<A, B>(detail::range_ball_hessian<space>(v, distance, sigma));
  }

  void validate() const {
    require_positive_number("RangeBearingBall.distance", distance, "leave out a range of zero: its direction has no meaning");
    require_positive("RangeBearingBall.sigma", sigma);
    require_unit("RangeBearingBall.direction", direction);
    require_concentration("RangeBearingBall.kappa", kappa);
  }
};

}  // namespace holdfast
