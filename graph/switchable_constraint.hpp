// Switchable constraints (Sünderhauf & Protzel, "Switchable constraints for robust pose graph SLAM", IROS 2012) without their switches.
// Each doubtful term has a switch ω in [0, 1] that the solver is free to turn, and a prior that wants it on. With the paper's linear switch
// function, the term and its prior of information Ξ = c² cost, times two,
//
//   h(ω) = ω² s + Ξ (1 − ω)²,     s = ‖r‖²
//
// Eliminated in closed form. h'(ω) = 2ωs − 2Ξ(1 − ω) is zero at ω* = Ξ/(Ξ + s) alone, and h'' = 2(s + Ξ) > 0: the one minimum. It lies in
// (0, 1], so the bounds of ω never bind. There
//
//   h(ω*) = Ξ² s/(Ξ + s)² + Ξ s²/(Ξ + s)² = Ξ s/(Ξ + s)     with slope Ξ²/(Ξ + s)² = ω*² in s
//
// which is GemanMcClure{c}, and that is the loss this converts to. The switches of different terms share nothing else, so the least cost
// over states and switches is the least over the states of the cost with the loss; states are a minimum of the one where they are of
// the other, with the switches at ω*. A loss needs no variable for each switch, and its switches are never behind the states.
//
//   graph.add(loop, keys, SwitchableConstraint{1});   // Ξ = 1, the paper's
//
// For files and command lines "switchable:1" after register_loss<SwitchableConstraint>(), which the program `holdfast` calls;
// it is printed as what it is, geman_mcclure:1.
#pragma once

#include <holdfast/graph/loss.hpp>

namespace holdfast {

struct SwitchableConstraint {
  double c = 1;  ///< > 0 [sigmas]: √Ξ, how firmly the prior holds the switch on

  /// ω* of a term whose residual has the squared length s.
  double switch_at(double s) const { return c * c / (c * c + s); }

  operator Loss() const { return GemanMcClure{c}; }
  static const char* name() { return "switchable"; }
  double scale() const { return c; }
};

}  // namespace holdfast
