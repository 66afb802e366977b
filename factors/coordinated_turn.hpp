// Motion at an unknown turn rate that wanders:   r = W [F_CT(ω_k) x_k − x_{k+1}; ω_k − ω_{k+1}],   W 5 × 5
//
// Variables: a Turning2 [px vx py vy ω] before and after dt [s]; F_CT as in constant_turn.hpp (paper B, eq. 3). In a Window the turn rate
// is learned: window.add_agent('A', [](double seconds) { return CoordinatedTurn{seconds, q, q_turn}; }). The noise is white acceleration of
// density q [m²/s³] and white turn acceleration of density q_turn [rad²/s³], independent of each other: covariance q [dt³/3 dt²/2; dt²/2
// dt] on each axis, q_turn dt on ω.
#pragma once

#include <holdfast/factors/detail/rules.hpp>
#include <holdfast/graph/factor.hpp>
#include <holdfast/graph/variables/turning2.hpp>

namespace holdfast {

struct CoordinatedTurn {
  double dt;      ///< [s]
  double q;       ///< [m²/s³]
  double q_turn;  ///< [rad²/s³]

  using Variables = variables<Turning2, Turning2>;
  static constexpr int residual_dim = 5;
  static const char* name() { return "CoordinatedTurn"; }
  static constexpr auto fields() {
    return std::tuple(field("dt", &CoordinatedTurn::dt), field("q", &CoordinatedTurn::q), field("q_turn", &CoordinatedTurn::q_turn));
  }

  /// [F_CT(ω) x; ω] and its derivative by [x; ω].
  struct Prediction {
    Vector<5> mean;
    Matrix<5, 5> F;
  };
  Prediction predicted(const Turning2& x) const {
    const double theta = x.turn_rate() * dt, sine = std::sin(theta), cosine = std::cos(theta);
    const double half = sinc(theta / 2);
    const double s = dt * sinc(theta), c = dt * std::sin(theta / 2) * half;  // dt sin θ/θ, dt (1 − cos θ)/θ
    const double ds = dt * dt * sinc_slope(theta);                           // by ω
    const double dc = dt * dt * (sinc(theta) - 0.5 * half * half);
    const double vx = x.value[1], vy = x.value[3];
    Prediction prediction;
    prediction.F << 1, s, 0, -c, ds * vx - dc * vy,            //
        0, cosine, 0, -sine, -dt * (sine * vx + cosine * vy),  //
        0, c, 1, s, dc * vx + ds * vy,                         //
        0, sine, 0, cosine, dt * (cosine * vx - sine * vy),    //
        0, 0, 0, 0, 1;
    prediction.mean << prediction.F.topLeftCorner<4, 4>() * x.value.head<4>(), x.turn_rate();
    return prediction;
  }
  /// The covariance of what is added to it.
  Matrix<5, 5> covariance() const {
    Matrix<5, 5> Q = Matrix<5, 5>::Zero();
    for (int i = 0; i < 4; i += 2) Q.block<2, 2>(i, i) << q * dt * dt * dt / 3, q * dt * dt / 2, q * dt * dt / 2, q * dt;
    Q(4, 4) = q_turn * dt;
    return Q;
  }

  Vector<5> operator()(const Turning2& x, const Turning2& next, Jacobians<CoordinatedTurn>* J = nullptr) const {
    const Matrix<5, 5> W = sqrt_information();
    const Prediction prediction = predicted(x);
    if (J != nullptr) {
      J->all.leftCols<5>().noalias() = W * prediction.F;
      J->all.rightCols<5>() = -W;
    }
    return W * (prediction.mean - next.value);
  }

  void validate() const {
    require_positive_number("CoordinatedTurn.dt", dt, "give the time between the two states in seconds");
    require_positive_number("CoordinatedTurn.q", q, "give the spectral density of the acceleration in m^2/s^3");
    require_positive_number("CoordinatedTurn.q_turn", q_turn, "give the spectral density of the turn acceleration in rad^2/s^3");
  }

 private:
  static double sinc(double angle) { return angle == 0 ? 1 : std::sin(angle) / angle; }
  /// (θ cos θ − sin θ)/θ²; below 1e-4 its series, which is exact there.
  static double sinc_slope(double theta) {
    return std::abs(theta) < 1e-4 ? -theta / 3 : (theta * std::cos(theta) - std::sin(theta)) / (theta * theta);
  }
  /// W, upper triangular, with Wᵀ W = covariance⁻¹.
  Matrix<5, 5> sqrt_information() const {
    Matrix<5, 5> W = Matrix<5, 5>::Zero();
    for (int i = 0; i < 4; i += 2)
      W.block<2, 2>(i, i) << std::sqrt(12 / (q * dt * dt * dt)), -std::sqrt(3 / (q * dt)), 0, 1 / std::sqrt(q * dt);
    W(4, 4) = 1 / std::sqrt(q_turn * dt);
    return W;
  }
};

}  // namespace holdfast
