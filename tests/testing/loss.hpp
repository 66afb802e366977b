// For tests of losses, yours included (installed; needs Eigen only):
//
//   EXPECT_EQ(holdfast::testing::check_loss(MyLoss{2.0}), "");
#pragma once

#include <cmath>
#include <holdfast/graph/loss.hpp>
#include <sstream>
#include <string>

namespace holdfast::testing {

struct LossCheck {
  double slope_at_zero = 1;  ///< ρ'(0); other than 1 by design for Absolute (1/width) and StudentT ((ν+d)/ν)
  int components = 1;        ///< d, of the block
  double smallest = 1e-6;    ///< s from here
  double largest = 1e6;      ///< to here: both sides of any threshold in sigmas
  double tolerance = 1e-6;   ///< relative
};

namespace detail {

class LossChecker {
 public:
  LossChecker(const Loss& loss, const LossCheck& check) : loss_(loss), check_(check) {}

  std::string broken() {
    const Rho zero = rho(0);
    if (zero.value != 0) broken_ << "rho(0) = " << zero.value << ", not 0\n";
    if (differ(zero.first, check_.slope_at_zero, std::abs(check_.slope_at_zero)))
      broken_ << "rho'(0) = " << zero.first << ", not " << check_.slope_at_zero << "\n";
    const double ratio = std::pow(check_.largest / check_.smallest, 1.0 / 400);
    double before = 0;
    for (double s = check_.smallest; s <= check_.largest && broken_.str().empty(); before = s, s *= ratio) {
      check_signs(s);
      check_concavity(before, s);
      check_derivatives(s);
    }
    return broken_.str();
  }

 private:
  Rho rho(double s) const { return loss_.rho(s, check_.components); }
  bool differ(double a, double b, double scale) const { return !(std::abs(a - b) <= check_.tolerance * scale); }
  std::ostream& at(double s) { return broken_ << "at s = " << s << ": "; }

  void check_signs(double s) {
    const Rho here = rho(s);
    if (!(std::isfinite(here.value) && std::isfinite(here.first) && std::isfinite(here.second))) at(s) << "it is not finite\n";
    if (here.first < 0) at(s) << "rho' = " << here.first << " < 0, which rewards what is worse\n";
    if (here.second > 0) at(s) << "rho'' = " << here.second << " > 0: not concave\n";
  }
  // Of a concave ρ: ρ'(b) (b − a) ≤ ρ(b) − ρ(a) ≤ ρ'(a) (b − a). A jump breaks it wherever it is.
  void check_concavity(double a, double b) {
    const Rho low = rho(a), high = rho(b);
    const double rise = high.value - low.value, slack = check_.tolerance * (std::abs(high.value) + std::abs(rise));
    if (rise > low.first * (b - a) + slack || rise < high.first * (b - a) - slack)
      at(b) << "rho has risen by " << rise << " since s = " << a << ", which rho' = " << low.first << " … " << high.first
            << " does not allow: it jumps, is not concave, or rho' is not its derivative\n";
  }
  void check_derivatives(double s) {
    const double h = 1e-5 * s, least = 1e-9 * check_.slope_at_zero;
    const Rho down = rho(s - h), here = rho(s), up = rho(s + h);
    const double left = here.first - down.first, right = up.first - here.first;
    if (std::abs(right - left) > 1e-2 * std::abs(right + left)) return;  // a corner lies between, or ρ' hardly changes
    const double slope = (up.value - down.value) / (2 * h), bend = (up.first - down.first) / (2 * h);
    if (differ(here.first, slope, std::abs(here.first) + 1e-2 * std::abs(here.value) / s + least))
      at(s) << "rho' = " << here.first << ", but rho's difference says " << slope << "\n";
    if (differ(here.second, bend, std::abs(here.second) + 1e-2 * std::abs(here.first) / s + least / s))
      at(s) << "rho'' = " << here.second << ", but the difference of rho' says " << bend << "\n";
  }

  const Loss& loss_;
  LossCheck check_;
  std::ostringstream broken_;
};

}  // namespace detail

/// What of the contract of graph/loss.hpp this loss breaks, in words; empty where it keeps it. Looks at ρ(0) and ρ'(0) and, at 400 values
/// of s from the smallest to the largest: at the signs of ρ' and ρ'', at whether ρ rises as a concave function with this ρ' does, and at ρ'
/// and ρ'' against central differences (but next to a corner, such as Huber's threshold).
inline std::string check_loss(const Loss& loss, const LossCheck& check = {}) { return detail::LossChecker(loss, check).broken(); }

}  // namespace holdfast::testing
