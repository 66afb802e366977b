// Motion at a known turn rate ω [rad/s] over dt [s]:   r = W (F_CT(ω) x_k − x_{k+1}),   W 4 × 4 with Wᵀ W = information     (paper B, eq.
// 3)
//
// State [px vx py vy] (Motion2, world frame), with θ = ω dt, s = dt sin θ/θ, c = dt (1 − cos θ)/θ:
//   F_CT = [1 s 0 −c; 0 cos θ 0 −sin θ; 0 c 1 s; 0 sin θ 0 cos θ]
// ω > 0 turns left. At ω = 0 this is constant velocity, reached smoothly: (1 − cos θ)/θ = sin(θ/2) sinc(θ/2).
#pragma once

#include <holdfast/factors/detail/rules.hpp>
#include <holdfast/factors/whitening.hpp>
#include <holdfast/graph/factor.hpp>
#include <holdfast/graph/variables/kinematic.hpp>

namespace holdfast {

template <class V>
struct ConstantTurn;

template <>
struct ConstantTurn<Motion2> {
  double dt;     ///< [s]
  double omega;  ///< [rad/s]
  Matrix<4, 4> sqrt_information;

  using Variables = variables<Motion2, Motion2>;
  static constexpr int residual_dim = 4;
  static constexpr bool is_linear = true;
  static const char* name() { return "ConstantTurn"; }
  static constexpr auto fields() {
    return std::tuple(field("dt", &ConstantTurn::dt), field("omega", &ConstantTurn::omega),
                      field("sqrt_information", &ConstantTurn::sqrt_information));
  }

  static ConstantTurn from_covariance(double dt, double omega, const Matrix<4, 4>& covariance) {
    return {dt, omega, sqrt_information_from_covariance<4>(covariance, "ConstantTurn.covariance")};
  }

  /// F_CT(ω).
  Matrix<4, 4> transition() const {
    const auto sinc = [](double angle) { return angle == 0 ? 1 : std::sin(angle) / angle; };
    const double theta = omega * dt;
    const double s = dt * sinc(theta), c = dt * std::sin(theta / 2) * sinc(theta / 2);
    Matrix<4, 4> F;
    F << 1, s, 0, -c, 0, std::cos(theta), 0, -std::sin(theta), 0, c, 1, s, 0, std::sin(theta), 0, std::cos(theta);
    return F;
  }

  Vector<4> operator()(const Motion2& x, const Motion2& next, Jacobians<ConstantTurn>* J = nullptr) const {
    const Matrix<4, 4> F = transition();
    if (J != nullptr) {
      J->wrt<0>().noalias() = sqrt_information * F;
      J->wrt<1>() = -sqrt_information;
    }
    return sqrt_information * (F * x.value - next.value);
  }

  void validate() const {
    require_positive_number("ConstantTurn.dt", dt, "give the time between the two states in seconds");
    require_finite("ConstantTurn.omega", omega);
    require_finite("ConstantTurn.sqrt_information", sqrt_information);
  }
};

}  // namespace holdfast
