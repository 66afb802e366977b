// Motion over m steps of dt [s], the acceleration white noise:   r = W (F^m x_k − x_{k+m}),   W = Σ^{-1/2} (symmetric)
//
// Paper A (1): x_{k+1} = F x_k + G w_k, per axis F = [1 dt; 0 1], G = diag(dt²/2, dt), w ~ N(0, R), R dim × dim [(m/s²)²]. Σ is one of
//   exact       Q_m = Σ_{i<m} F^i G R Gᵀ F^{iᵀ}                    m steps of (1) as they are: the right one
//   continuous  q [T³/3 T²/2; T²/2 T] per axis, T = duration       q [m²/s³], the spectral density of the acceleration
//   paper       G^{[m]} R G^{[m]ᵀ}, dt replaced by m dt in G       as in (6); at m = 5 its velocity variance is 5 times too large (D.A.1)
//   recursive   P^{[m]} = F^m P* F^{mᵀ} + G^{[m]} R G^{[m]ᵀ}       as in (7); rightly only the first node's arrival cost
//               (notes D.A.2–3)
//   steered     [T³/3 T²/2; T²/2 T] of the density along uuᵀ + across (I − uuᵀ), u the direction of travel: continuous, where the noise
//               along the way and across it differ; W per axis upper triangular
// The symmetric root makes a per-component Huber mean the same as in the paper (notes D.A.5). Motion2 or Motion3.
#pragma once

#include <algorithm>
#include <holdfast/factors/detail/rules.hpp>
#include <holdfast/factors/detail/transition.hpp>
#include <holdfast/factors/whitening.hpp>
#include <holdfast/graph/batch.hpp>
#include <holdfast/graph/variables.hpp>

namespace holdfast {

template <class V>
struct WhiteAcceleration {
  static_assert(V::order == 2, "the state per axis is [p, v]: Motion2 or Motion3");
  using Square = Matrix<V::dim, V::dim>;
  enum class Kind { exact, continuous, paper, recursive, steered };
  Kind kind;
  double dt;  ///< of one step [s]; of the whole motion for continuous
  int steps;
  Square R;  ///< covariance of w; q times the identity for continuous; for steered its density [m²/s³], of each pair of axes in a block
  Square sqrt_information;

  using Variables = variables<V, V>;
  static constexpr int residual_dim = V::dim;
  static constexpr bool is_linear = true;
  static const char* name() { return "WhiteAcceleration"; }
  static constexpr auto fields() {
    return std::tuple(field("kind", &WhiteAcceleration::kind), field("dt", &WhiteAcceleration::dt),
                      field("steps", &WhiteAcceleration::steps), field("R", &WhiteAcceleration::R),
                      field("sqrt_information", &WhiteAcceleration::sqrt_information));
  }

  double duration() const { return steps * dt; }

  static WhiteAcceleration exact(double dt, int steps, const Square& R) {
    require_step(dt, steps);
    const Square F = transition<V>(dt);
    const Square one_step = noise(dt, R);
    Square Q = one_step;
    for (int i = 1; i < steps; ++i) Q = F * Q * F.transpose() + one_step;
    return make(Kind::exact, dt, steps, R, Q);
  }
  static WhiteAcceleration continuous(double duration, double q) {
    require_step(duration, 1);
    require_positive_number("WhiteAcceleration.q", q, "give the spectral density of the acceleration in m^2/s^3");
    const double T = duration;
    Matrix<2, 2> axis;
    axis << T * T * T / 3, T * T / 2, T * T / 2, T;
    return make(Kind::continuous, duration, 1, q * Square::Identity(), on_each_axis<V>(q * axis));
  }
  static WhiteAcceleration paper(double dt, int steps, const Square& R) {
    require_step(dt, steps);
    return make(Kind::paper, dt, steps, R, noise(steps * dt, R));
  }
  /// P_start: covariance P* of x_k after its measurement; see CovarianceRecursion.
  static WhiteAcceleration recursive(double dt, int steps, const Square& R, const Square& P_start) {
    require_step(dt, steps);
    const Square F = transition<V>(steps * dt);
    return make(Kind::recursive, dt, steps, R, F * P_start * F.transpose() + noise(steps * dt, R));
  }

  /// direction: of travel, of any length > 0; along, across [m²/s³].
  static WhiteAcceleration steered(double duration, const Vector<V::axes>& direction, double along, double across) {
    require_step(duration, 1);
    require_positive_number("WhiteAcceleration.along", along, "give the spectral density of the acceleration along the way in m^2/s^3");
    require_positive_number("WhiteAcceleration.across", across, "give the spectral density of the acceleration across the way in m^2/s^3");
    if (!(direction.norm() > 0)) fail<BadNumber>("WhiteAcceleration.direction has no length; give the direction of travel");
    const Axes forward = direction.normalized() * direction.normalized().transpose();
    return of_density(duration, along * forward + across * (Axes::Identity() - forward));
  }

  /// One factor for m times as many steps.
  WhiteAcceleration merged(int m) const {
    require_count("WhiteAcceleration.merged(m)", m);
    switch (kind) {
      case Kind::exact:
        return exact(dt, m * steps, R);
      case Kind::continuous:
        return continuous(m * dt, R(0, 0));
      case Kind::paper:
        return paper(dt, m * steps, R);
      case Kind::steered:
        return of_density(m * dt, density());
      case Kind::recursive:
        break;
    }
    fail<BadOption>(
        "WhiteAcceleration::merged: the recursive covariance depends on the measurements before it; make it by CovarianceRecursion");
  }

  Vector<V::dim> operator()(const V& x, const V& next, Jacobians<WhiteAcceleration>* J = nullptr) const {
    return transition_residual(sqrt_information, duration(), x, next, J);
  }

  void validate() const {
    require_step(dt, steps);
    require_finite("WhiteAcceleration.R", R);
    require_finite("WhiteAcceleration.sqrt_information", sqrt_information);
  }

 private:
  static void require_step(double dt, int steps) {
    require_positive_number("WhiteAcceleration.dt", dt, "give the time between the two states in seconds");
    require_count("WhiteAcceleration.steps", steps);
  }
  using Axes = Matrix<V::axes, V::axes>;
  Axes density() const {
    Axes all;
    for (int i = 0; i < V::axes; ++i)
      for (int j = 0; j < V::axes; ++j) all(i, j) = R(2 * i + 1, 2 * j + 1);
    return all;
  }
  static WhiteAcceleration of_density(double T, const Axes& density) {
    Matrix<2, 2> axis;  // axisᵀ axis = [T³/3 T²/2; T²/2 T]⁻¹, upper triangular: fewer numbers that are not 0
    axis << std::sqrt(12 / (T * T * T)), -std::sqrt(3 / T), 0, 1 / std::sqrt(T);
    const Axes root = symmetric_sqrt_information_from_covariance<V::axes>(density, "WhiteAcceleration.density");
    WhiteAcceleration motion{Kind::steered, T, 1, Square::Zero(), Square::Zero()};
    for (int i = 0; i < V::axes; ++i)
      for (int j = 0; j < V::axes; ++j) {
        motion.R.template block<2, 2>(2 * i, 2 * j) = density(i, j) * Matrix<2, 2>::Identity();
        motion.sqrt_information.template block<2, 2>(2 * i, 2 * j) = root(i, j) * axis;
      }
    return motion;
  }
  /// G(T) R G(T)ᵀ.
  static Square noise(double T, const Square& R) {
    const Vector<V::dim> G = Vector<2>(T * T / 2, T).template replicate<V::axes, 1>();
    return G.asDiagonal() * R * G.asDiagonal();
  }
  static WhiteAcceleration make(Kind kind, double dt, int steps, const Square& R, const Square& covariance) {
    return {kind, dt, steps, R, symmetric_sqrt_information_from_covariance<V::dim>(covariance, "WhiteAcceleration.covariance")};
  }
};

/// How a vehicle moves that steers and hardly changes its speed v: white acceleration of the densities `along` v² along the way it goes and
/// `turn` v² across it. One setting fits slow and fast ones. A motion for Window::add_agent (solvers/window/window.hpp):
///
///   window.add_agent('A', Steering<Motion2>{});
template <class V>
struct Steering {
  double turn = 0.1;       ///< > 0 [1/s]: the density of the turn rate [rad²/s]
  double along = 0.003;    ///< > 0 [1/s]
  double speed = 20;       ///< > 0 [m/s]: v, and `turn` in every direction, where nothing is known of the state; 2 · speed is the most
  double least_speed = 1;  ///< > 0 [m/s]: one at rest may start

  /// Over so many seconds, from this state; null: nothing is known of it.
  WhiteAcceleration<V> operator()(double seconds, const V* from) const {
    const double v = from == nullptr ? speed : std::clamp(from->derivative(1).norm(), least_speed, 2 * speed);
    Vector<V::axes> direction = Vector<V::axes>::Unit(0);
    if (from != nullptr && from->derivative(1).norm() > 0) direction = from->derivative(1);
    return WhiteAcceleration<V>::steered(seconds, direction, (from == nullptr ? turn : along) * v * v, turn * v * v);
  }
};

/// Paper A's recursion P*[k−m] → P^{[m]}[k] → P*[k] (the Kalman filter's, with m missing steps; notes D.A.2 for its index).
template <class V>
struct CovarianceRecursion {
  Matrix<V::dim, V::dim> P;  ///< P* after the last measurement

  /// The factor to the next measured state, m steps on; Q [m²] is the covariance of the position measured there.
  WhiteAcceleration<V> step(double dt, int m, const Matrix<V::dim, V::dim>& R, const Matrix<V::axes, V::axes>& Q) {
    const auto factor = WhiteAcceleration<V>::recursive(dt, m, R, P);
    const Matrix<V::axes, V::dim> C = V::position_jacobian();
    const Matrix<V::axes, V::axes> W = sqrt_information_from_covariance<V::axes>(Q, "CovarianceRecursion.Q");
    const Matrix<V::dim, V::dim> predicted_information = factor.sqrt_information * factor.sqrt_information;
    P = (predicted_information + C.transpose() * (W.transpose() * W) * C).inverse();
    return factor;
  }
};

// Compiled into the library (factors/compiled.cpp), not anew by whoever adds them to a graph.
extern template class Batch<WhiteAcceleration<Motion2>>;

}  // namespace holdfast
