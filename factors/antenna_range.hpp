// A measured distance between two antennas, as UWB radios give it. d = ‖q_b − q_a‖ [m]:
//
//   AntennaRange                  r = (d − distance) / sigma
//   AntennaRangeWithBias          r = (d + bias − distance) / sigma                  bias [m]: of a radio, a pair, or an anchor
//   AntennaRangeWithDelays        r = (d + delay_a + delay_b − distance) / sigma     delay [m]: of either radio, so n of n radios, not n²
//   AntennaRangeWithScale         r = ((1 + scale) d − distance) / sigma             scale [1]: 0.001 is 1 mm too long at each metre
//   AntennaRangeWithBiasAndScale  r = ((1 + scale) d + bias − distance) / sigma
//
// q_a = p_a + R_a l_a is where the antenna of a is: l_a [m], its lever arm, in the body frame of a (the same for b). A point has no body
// frame: its lever arm is 0. Bias, delay and scale are Scalars that are estimated: give each a prior. The bias is what the radios' delays
// add to every distance (Decawave APS014, "Antenna delay calibration"); the scale is that of their clocks, or of the map, or of sound.
// An anchor is a variable too: with a prior its place is estimated along (self-calibration), fixed it is a constant.
// What cannot be told apart, check() says: bias and distance without turns of the robot or with one anchor alone; the delays of two
// radios that only range to one another; the scale of everything where neither odometry nor a known anchor holds it.
// Where both antennas coincide (below kZeroDistance) the residual is its value at 0 and the Jacobian by the poses is zero.
// The same between other moments, clocks and senses: range_time_offset.hpp, two_way_range.hpp, time_difference.hpp, antenna_bearing.hpp.
// Ranges without line of sight are too long: one_sided(…) (graph/loss.hpp), MaxMixture (graph/max_mixture.hpp).
#pragma once

#include <holdfast/factors/detail/antenna.hpp>

namespace holdfast {

namespace detail {
/// Of every range between two antennas with known lever arms.
template <class F>
constexpr auto antenna_range_fields() {
  return std::tuple(field("distance", &F::distance), field("sigma", &F::sigma), field("lever_a", &F::lever_a),
                    field("lever_b", &F::lever_b));
}
}  // namespace detail

template <class A, class B>
struct AntennaRange {
  using Lever = Vector<space_dim<A>>;
  double distance;  ///< [m]
  double sigma;     ///< [m]
  Lever lever_a;    ///< of the antenna in the body frame of a [m]
  Lever lever_b;    ///< of the antenna in the body frame of b [m]

  using Variables = variables<A, B>;
  static constexpr int residual_dim = 1;
  static const char* name() { return "AntennaRange"; }
  static constexpr auto fields() { return detail::antenna_range_fields<AntennaRange>(); }

  Vector<1> operator()(const A& a, const B& b, Jacobians<AntennaRange>* J = nullptr) const {
    Matrix<1, Variables::total_dim> D;
    const double measured = detail::antenna_distance(a, lever_a, b, lever_b, J == nullptr ? nullptr : &D);
    if (J != nullptr) J->all = D / sigma;
    return Vector<1>((measured - distance) / sigma);
  }

  Vector<1> raw(const Vector<1>& r) const { return sigma * r; }  ///< [m]
  void validate() const {
    require_not_negative("AntennaRange.distance", distance);
    require_positive("AntennaRange.sigma", sigma);
    detail::require_lever<A>("AntennaRange.lever_a", lever_a);
    detail::require_lever<B>("AntennaRange.lever_b", lever_b);
  }
};

template <class A, class B>
struct AntennaRangeWithBias {
  using Lever = Vector<space_dim<A>>;
  double distance;  ///< [m]
  double sigma;     ///< [m]
  Lever lever_a;    ///< of the antenna in the body frame of a [m]
  Lever lever_b;    ///< of the antenna in the body frame of b [m]

  using Variables = variables<A, B, Scalar>;
  static constexpr int residual_dim = 1;
  static const char* name() { return "AntennaRangeWithBias"; }
  static constexpr auto fields() { return detail::antenna_range_fields<AntennaRangeWithBias>(); }

  Vector<1> operator()(const A& a, const B& b, const Scalar& bias, Jacobians<AntennaRangeWithBias>* J = nullptr) const {
    Matrix<1, A::dim + B::dim> D;
    const double measured = detail::antenna_distance(a, lever_a, b, lever_b, J == nullptr ? nullptr : &D);
    if (J != nullptr) J->all << D / sigma, 1 / sigma;
    return Vector<1>((measured + bias.value - distance) / sigma);
  }

  Vector<1> raw(const Vector<1>& r) const { return sigma * r; }  ///< [m]
  void validate() const { AntennaRange<A, B>{distance, sigma, lever_a, lever_b}.validate(); }
};

template <class A, class B>
struct AntennaRangeWithDelays {
  using Lever = Vector<space_dim<A>>;
  double distance;  ///< [m]
  double sigma;     ///< [m]
  Lever lever_a;    ///< of the antenna in the body frame of a [m]
  Lever lever_b;    ///< of the antenna in the body frame of b [m]

  using Variables = variables<A, B, Scalar, Scalar>;
  static constexpr int residual_dim = 1;
  static const char* name() { return "AntennaRangeWithDelays"; }
  static constexpr auto fields() { return detail::antenna_range_fields<AntennaRangeWithDelays>(); }

  Vector<1> operator()(const A& a, const B& b, const Scalar& delay_a, const Scalar& delay_b,
                       Jacobians<AntennaRangeWithDelays>* J = nullptr) const {
    Matrix<1, A::dim + B::dim> D;
    const double d = detail::antenna_distance(a, lever_a, b, lever_b, J == nullptr ? nullptr : &D);
    if (J != nullptr) J->all << D / sigma, 1 / sigma, 1 / sigma;
    return Vector<1>((d + delay_a.value + delay_b.value - distance) / sigma);
  }

  Vector<1> raw(const Vector<1>& r) const { return sigma * r; }  ///< [m]
  void validate() const { AntennaRange<A, B>{distance, sigma, lever_a, lever_b}.validate(); }
};

template <class A, class B>
struct AntennaRangeWithScale {
  using Lever = Vector<space_dim<A>>;
  double distance;  ///< [m]
  double sigma;     ///< [m]
  Lever lever_a;    ///< of the antenna in the body frame of a [m]
  Lever lever_b;    ///< of the antenna in the body frame of b [m]

  using Variables = variables<A, B, Scalar>;
  static constexpr int residual_dim = 1;
  static const char* name() { return "AntennaRangeWithScale"; }
  static constexpr auto fields() { return detail::antenna_range_fields<AntennaRangeWithScale>(); }

  Vector<1> operator()(const A& a, const B& b, const Scalar& scale, Jacobians<AntennaRangeWithScale>* J = nullptr) const {
    Matrix<1, A::dim + B::dim> D;
    const double d = detail::antenna_distance(a, lever_a, b, lever_b, J == nullptr ? nullptr : &D);
    if (J != nullptr) J->all << (1 + scale.value) * D / sigma, d / sigma;
    return Vector<1>(((1 + scale.value) * d - distance) / sigma);
  }

  Vector<1> raw(const Vector<1>& r) const { return sigma * r; }  ///< [m]
  void validate() const { AntennaRange<A, B>{distance, sigma, lever_a, lever_b}.validate(); }
};

template <class A, class B>
struct AntennaRangeWithBiasAndScale {
  using Lever = Vector<space_dim<A>>;
  double distance;  ///< [m]
  double sigma;     ///< [m]
  Lever lever_a;    ///< of the antenna in the body frame of a [m]
  Lever lever_b;    ///< of the antenna in the body frame of b [m]

  using Variables = variables<A, B, Scalar, Scalar>;
  static constexpr int residual_dim = 1;
  static const char* name() { return "AntennaRangeWithBiasAndScale"; }
  static constexpr auto fields() { return detail::antenna_range_fields<AntennaRangeWithBiasAndScale>(); }

  Vector<1> operator()(const A& a, const B& b, const Scalar& bias, const Scalar& scale,
                       Jacobians<AntennaRangeWithBiasAndScale>* J = nullptr) const {
    Matrix<1, A::dim + B::dim> D;
    const double d = detail::antenna_distance(a, lever_a, b, lever_b, J == nullptr ? nullptr : &D);
    if (J != nullptr) J->all << (1 + scale.value) * D / sigma, 1 / sigma, d / sigma;
    return Vector<1>(((1 + scale.value) * d + bias.value - distance) / sigma);
  }

  Vector<1> raw(const Vector<1>& r) const { return sigma * r; }  ///< [m]
  void validate() const { AntennaRange<A, B>{distance, sigma, lever_a, lever_b}.validate(); }
};

}  // namespace holdfast
