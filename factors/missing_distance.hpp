// A range that did not arrive (paper C, eq. 8–9, coupled as it must be: notes C, D.1). The unknown range Ω is expected near the
// last one that did, Ω ~ N(d_prev, ρ²), and bounds the distance as in RangeBall. Lifted (Ω a Scalar variable) or eliminated:
//
//   MissingDistancePrior     r = (Ω − d_prev) / ρ
//   MissingDistanceBall      r = max(0, ‖p_a − p_b‖ − Ω) / σ
//   MissingDistance          ‖r‖ = max(0, ‖p_a − p_b‖ − d_prev) / √(σ² + ρ²)   the minimum of both over Ω: a RangeBall; estimate() has Ω
//
// A and B: anything with a position; d_prev, σ, ρ [m]. The ball is one-sided and d_prev a biased guess when distances change: it helps
// a filter with a fixed previous position and can hurt a smoother, which may prefer no factor at all for a lost range.
#pragma once

#include <algorithm>
#include <holdfast/factors/range_ball.hpp>
#include <holdfast/graph/variables/kinematic.hpp>

namespace holdfast {

struct MissingDistancePrior {
  double d_prev;  ///< the last distance that arrived [m]
  double rho;     ///< how far a distance moves between measurements, one sigma [m]

  using Variables = variables<Scalar>;
  static constexpr int residual_dim = 1;
  static constexpr bool is_linear = true;
  static const char* name() { return "MissingDistancePrior"; }
  static constexpr auto fields() {
    return std::tuple(field("d_prev", &MissingDistancePrior::d_prev), field("rho", &MissingDistancePrior::rho));
  }

  Vector<1> operator()(const Scalar& omega, Jacobians<MissingDistancePrior>* J = nullptr) const {
    if (J != nullptr) J->all(0, 0) = 1 / rho;
    return Vector<1>((omega.value - d_prev) / rho);
  }

  void validate() const {
    require_not_negative("MissingDistancePrior.d_prev", d_prev);
    require_positive("MissingDistancePrior.rho", rho);
  }
};

template <class A, class B>
struct MissingDistanceBall {
  double sigma;  ///< [m]

  using Variables = variables<A, B, Scalar>;
  static constexpr int residual_dim = 1;
  static constexpr bool is_convex = true;  // jointly in positions and Ω
  static const char* name() { return "MissingDistanceBall"; }
  static constexpr auto fields() { return std::tuple(field("sigma", &MissingDistanceBall::sigma)); }

  Vector<1> operator()(const A& a, const B& b, const Scalar& omega, Jacobians<MissingDistanceBall>* J = nullptr) const {
    const auto norm = safe_norm(displacement(a, b));
    const bool inside = norm.value <= omega.value;
    if (J != nullptr) {
      const double slope = inside ? 0 : 1 / sigma;
      set_displacement_jacobian(slope * norm.gradient.transpose(), *J);
      J->template wrt<2>()(0, 0) = -slope;
    }
    return Vector<1>(inside ? 0 : (norm.value - omega.value) / sigma);
  }

  /// Of ½ (n − Ω)²/σ², n = ‖p_b − p_a‖ and u its gradient: by x = p_b − p_a u uᵀ + (1 − Ω/n)(I − u uᵀ), mixed −u, by Ω 1, over σ²; 0
  /// inside. Where the positions coincide and Ω < 0 the part of the positions is 0.
  Matrix<Variables::total_dim, Variables::total_dim> hessian(const A& a, const B& b, const Scalar& omega) const {
    constexpr int N = Variables::total_dim, positions = A::dim + B::dim;
    Matrix<N, N> H = Matrix<N, N>::Zero();
    const Vector<space_dim<A>> x = displacement(a, b);
    const auto norm = safe_norm(x);
    if (norm.value <= omega.value) return H;
    Jacobians<MissingDistanceBall> J;
    set_displacement_jacobian(norm.gradient.transpose(), J);
    if (norm.value > 0) H.template topLeftCorner<positions, positions>() = displacement_hessian<A, B>(ball_hessian(x, omega.value));
    H.template topRightCorner<positions, 1>() = -J.all.template leftCols<positions>().transpose();
    H.template bottomLeftCorner<1, positions>() = -J.all.template leftCols<positions>();
    H(N - 1, N - 1) = 1;
    return H / (sigma * sigma);
  }

  void validate() const { require_positive("MissingDistanceBall.sigma", sigma); }
};

template <class A, class B>
struct MissingDistance {
  double d_prev;  ///< the last distance that arrived [m]
  double sigma;   ///< [m]
  double rho;     ///< how far a distance moves between measurements, one sigma [m]

  using Variables = variables<A, B>;
  static constexpr int residual_dim = space_dim<A>;
  static constexpr bool is_convex = true;
  static const char* name() { return "MissingDistance"; }
  static constexpr auto fields() {
    return std::tuple(field("d_prev", &MissingDistance::d_prev), field("sigma", &MissingDistance::sigma),
                      field("rho", &MissingDistance::rho));
  }

  Vector<residual_dim> operator()(const A& a, const B& b, Jacobians<MissingDistance>* J = nullptr) const {
    Matrix<residual_dim, residual_dim> D;
    const Vector<residual_dim> r =
        detail::range_ball<residual_dim>(displacement(a, b), d_prev, std::hypot(sigma, rho), J == nullptr ? nullptr : &D);
    if (J != nullptr) set_displacement_jacobian(D, *J);
    return r;
  }

  Matrix<Variables::total_dim, Variables::total_dim> hessian(const A& a, const B& b) const {
    return displacement_hessian<A, B>(detail::range_ball_hessian<residual_dim>(displacement(a, b), d_prev, std::hypot(sigma, rho)));
  }

  /// The eliminated Ω: the most probable distance, given the positions [m].
  double estimate(const A& a, const B& b) const {
    const double variance = rho * rho;
    const double excess = std::max(0.0, displacement(a, b).norm() - d_prev);
    return d_prev + variance / (sigma * sigma + variance) * excess;
  }

  Vector<residual_dim> raw(const Vector<residual_dim>& r) const { return std::hypot(sigma, rho) * r; }  ///< [m]
  void validate() const {
    require_not_negative("MissingDistance.d_prev", d_prev);
    require_positive("MissingDistance.sigma", sigma);
    require_positive("MissingDistance.rho", rho);
  }
};

}  // namespace holdfast
