// A measured range and direction of the same edge, in one packet (paper C, eq. 2–3):
//
//   r = [(‖x‖ − distance) / sigma ; √kappa (direction − x/‖x‖)],   x = p_b − p_a
//
// That is a Range and a VonMisesBearing under one loss: a packet is believed or rejected as a whole. Together they have a convex
// counterpart that neither has alone: RangeBearingBall, which keeps the distance on both sides. A and B: anything with a position.
#pragma once

#include <holdfast/factors/range.hpp>
#include <holdfast/factors/range_bearing_ball.hpp>
#include <holdfast/factors/von_mises_bearing.hpp>

namespace holdfast {

template <class A, class B>
struct RangeBearing {
  static constexpr int space = space_dim<A>;
  static constexpr int residual_dim = 1 + space;
  using Direction = Vector<space>;
  double distance;      ///< [m], > 0
  double sigma;         ///< [m]
  Direction direction;  ///< unit vector from a to b, world frame
  double kappa;         ///< concentration [1]

  using Variables = variables<A, B>;
  static const char* name() { return "RangeBearing"; }
  static constexpr auto fields() {
    return std::tuple(field("distance", &RangeBearing::distance), field("sigma", &RangeBearing::sigma),
                      field("direction", &RangeBearing::direction), field("kappa", &RangeBearing::kappa));
  }

  Vector<residual_dim> operator()(const A& a, const B& b, Jacobians<RangeBearing>* J = nullptr) const {
    const Range<A, B> range{distance, sigma};
    const VonMisesBearing<A, B> bearing{direction, kappa};
    Jacobians<Range<A, B>> of_range;
    Jacobians<VonMisesBearing<A, B>> of_bearing;
    Vector<residual_dim> r;
    r[0] = range(a, b, J == nullptr ? nullptr : &of_range)[0];
    r.template tail<space>() = bearing(a, b, J == nullptr ? nullptr : &of_bearing);
    if (J == nullptr) return r;
    J->all.row(0) = of_range.all;
    J->all.template bottomRows<space>() = of_bearing.all;
    return r;
  }

  RangeBearingBall<A, B> relaxed() const { return {distance, sigma, direction, kappa}; }

  void validate() const { relaxed().validate(); }
};

}  // namespace holdfast
