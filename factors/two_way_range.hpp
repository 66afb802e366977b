// Two-way ranging from its time stamps (UWB: IEEE 802.15.4z, 6.9; acoustic modems: with the speed of sound). Radio a sends, b answers after
// `reply`, and a hears the answer `round` after it sent:
//
//   single_sided_range(round, reply, speed)                        speed (round − reply) / 2 [m]
//   double_sided_range(round_a, reply_b, round_b, reply_a, speed)  speed (round_a round_b − reply_a reply_b) / (their sum) [m]
//   TwoWayRange   r = (‖q_b − q_a‖ + bias − speed/2 (round − (1 + 10⁻⁶ drift) reply)) / sigma
//
// All times are in seconds, each as the clock of the radio that measured it shows it. The clocks do not run alike: drift [ppm], a Scalar
// that is estimated, is how much faster the clock of a runs than that of b. Single-sided, 1 ppm of drift and a reply of 1 ms are 0.15 m:
// TwoWayRange estimates it, one for each pair, with a prior (crystals: 20 ppm) or the carrier's frequency offset as a measurement of it.
// Double-sided, with a second exchange in which b measures round_b and a replies after reply_a, the drift cancels but for one part in a
// million of the distance (Neirynck, Luk and McLaughlin, "An alternative double-sided two-way ranging method", WPNC 2016): what it gives
// is the distance of an AntennaRange… (antenna_range.hpp). bias [m], a Scalar as well, is speed/2 times the radios' delays; graph.fix() it
// where it is calibrated. The antenna of a is at q_a = p_a + R_a l_a (the same for b), as in antenna_range.hpp.
// Where both antennas coincide (below kZeroDistance) the residual is its value at 0 and the Jacobian by the poses is zero.
#pragma once

#include <holdfast/factors/detail/antenna.hpp>

namespace holdfast {

inline constexpr double kSpeedOfLight = 299792458;  ///< in vacuum [m/s]; in air 0.03 % less

/// [m]; may come out negative by its noise.
inline double single_sided_range(double round, double reply, double speed = kSpeedOfLight) { return 0.5 * speed * (round - reply); }

/// [m]. Throws BadNumber where the times do not add up to more than 0.
inline double double_sided_range(double round_a, double reply_b, double round_b, double reply_a, double speed = kSpeedOfLight) {
  const double sum = round_a + round_b + reply_a + reply_b;
  if (!(std::isfinite(sum) && sum > 0))
    fail<BadNumber>("double_sided_range(): the times ", round_a, ", ", reply_b, ", ", round_b, ", ", reply_a,
                    " s must be finite with a sum > 0; give differences of time stamps in seconds");
  // (Ra Rb − Da Db) / sum, written with the small differences Ra − Db and Rb − Da: else eight digits cancel.
  return speed * (round_a * (round_b - reply_a) + reply_a * (round_a - reply_b)) / sum;
}

template <class A, class B>
struct TwoWayRange {
  using Lever = Vector<space_dim<A>>;
  double round;   ///< by the clock of a [s]
  double reply;   ///< by the clock of b [s]
  double sigma;   ///< of the distance [m]
  double speed;   ///< of the signal [m/s]
  Lever lever_a;  ///< of the antenna in the body frame of a [m]
  Lever lever_b;  ///< of the antenna in the body frame of b [m]

  using Variables = variables<A, B, Scalar, Scalar>;
  static constexpr int residual_dim = 1;
  static const char* name() { return "TwoWayRange"; }
  static constexpr auto fields() {
    return std::tuple(field("round", &TwoWayRange::round), field("reply", &TwoWayRange::reply), field("sigma", &TwoWayRange::sigma),
                      field("speed", &TwoWayRange::speed), field("lever_a", &TwoWayRange::lever_a),
                      field("lever_b", &TwoWayRange::lever_b));
  }

  Vector<1> operator()(const A& a, const B& b, const Scalar& bias, const Scalar& drift, Jacobians<TwoWayRange>* J = nullptr) const {
    Matrix<1, A::dim + B::dim> D;
    const double d = detail::antenna_distance(a, lever_a, b, lever_b, J == nullptr ? nullptr : &D);
    const double per_ppm = 0.5e-6 * speed * reply;  // [m]
    if (J != nullptr) J->all << D / sigma, 1 / sigma, per_ppm / sigma;
    return Vector<1>((d + bias.value - single_sided_range(round, reply, speed) + per_ppm * drift.value) / sigma);
  }

  Vector<1> raw(const Vector<1>& r) const { return sigma * r; }  ///< [m]
  void validate() const {
    require_not_negative("TwoWayRange.round", round);
    require_not_negative("TwoWayRange.reply", reply);
    require_positive("TwoWayRange.sigma", sigma);
    require_positive("TwoWayRange.speed", speed);
    detail::require_lever<A>("TwoWayRange.lever_a", lever_a);
    detail::require_lever<B>("TwoWayRange.lever_b", lever_b);
  }
};

}  // namespace holdfast
