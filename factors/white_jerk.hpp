// Motion over a time T = duration [s], the jerk white noise (for turning targets):   r = W (F x_k − x_next),   Wᵀ W = Q⁻¹
//
// State [p, v, a] per axis, Accel2 or Accel3; F = [1 T T²/2; 0 1 T; 0 0 1] and, q [m²/s⁵] the spectral density of the jerk,
//   Q = q [T⁵/20 T⁴/8 T³/6; T⁴/8 T³/3 T²/2; T³/6 T²/2 T]        (Bar-Shalom, Li, Kirubarajan: Estimation…, 6.2.3, continuous Wiener
//   acceleration)
// W is triangular: Q spans many orders of magnitude over short times, and Cholesky alone does not care about units.
#pragma once

#include <holdfast/factors/detail/rules.hpp>
#include <holdfast/factors/detail/transition.hpp>
#include <holdfast/factors/whitening.hpp>

namespace holdfast {

template <class V>
struct WhiteJerk {
  static_assert(V::order == 3, "the state per axis is [p, v, a]: Accel2 or Accel3");
  double duration;  ///< [s]
  double q;         ///< [m²/s⁵]
  Matrix<V::dim, V::dim> sqrt_information;

  using Variables = variables<V, V>;
  static constexpr int residual_dim = V::dim;
  static constexpr bool is_linear = true;
  static const char* name() { return "WhiteJerk"; }
  static constexpr auto fields() {
    return std::tuple(field("duration", &WhiteJerk::duration), field("q", &WhiteJerk::q),
                      field("sqrt_information", &WhiteJerk::sqrt_information));
  }

  static WhiteJerk continuous(double duration, double q) {
    require_noise(duration, q);
    const double T = duration, T2 = T * T, T3 = T2 * T;
    Matrix<3, 3> Q;
    Q << T2 * T3 / 20, T2 * T2 / 8, T3 / 6, T2 * T2 / 8, T3 / 3, T2 / 2, T3 / 6, T2 / 2, T;
    return {duration, q, on_each_axis<V>(sqrt_information_from_covariance<3>(q * Q, "WhiteJerk.covariance"))};
  }

  /// One factor for m times as long.
  WhiteJerk merged(int m) const {
    require_count("WhiteJerk.merged(m)", m);
    return continuous(m * duration, q);
  }

  Vector<V::dim> operator()(const V& x, const V& next, Jacobians<WhiteJerk>* J = nullptr) const {
    return transition_residual(sqrt_information, duration, x, next, J);
  }

  void validate() const {
    require_noise(duration, q);
    require_finite("WhiteJerk.sqrt_information", sqrt_information);
  }

 private:
  static void require_noise(double duration, double q) {
    require_positive_number("WhiteJerk.duration", duration, "give the time between the two states in seconds");
    require_positive_number("WhiteJerk.q", q, "give the spectral density of the jerk in m^2/s^5");
  }
};

}  // namespace holdfast
