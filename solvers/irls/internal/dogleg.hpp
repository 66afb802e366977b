// Powell's dogleg: the step of a quadratic model that stays within a radius, from one factorisation. Internal.
#pragma once

#include <holdfast/solvers/irls/internal/quadratic_model.hpp>
#include <limits>

namespace holdfast::detail {

/// How far a quadratic model is trusted, measured in the metric of diag H. Open at first: a full Newton step.
class TrustRegion {
 public:
  double radius() const { return radius_; }
  /// After a step of this length that lowered the cost by gain_ratio times what the model said.
  void accept(double gain_ratio, double length);
  void reject(double length) { radius_ = 0.5 * length; }

 private:
  double radius_ = std::numeric_limits<double>::infinity();
};

/// Of one linearisation: from 0 to the minimum of the model along −D⁻¹g, D = diag H, and from there to Newton's step.
class Dogleg {
 public:
  explicit Dogleg(const QuadraticModel& system);

  /// Newton's step −(H + λ diag H)⁻¹ g with the least λ that makes the matrix definite; false where none does.
  bool begin(QuadraticModel& system);

  struct Step {
    double predicted;  ///< decrease of the cost that the model predicts
    double length;     ///< in the metric of D
    bool is_full;      ///< not short because of the radius: the minimum of the model is as near as that
  };
  /// The point of the path where it leaves the radius, or its end, into `step`. As often as one likes after begin().
  Step take(const QuadraticModel& system, double radius, std::vector<double>& step);

 private:
  void find_steepest(const QuadraticModel& system);
  /// The model along a·steepest + b·newton.
  Step combine(double a, double b, double length, std::vector<double>& step) const;

  std::vector<double> newton_, steepest_, H_steepest_;
  double newton_length_ = 0;  // in the metric of D
  double newton_slope_ = 0;   // gᵀ newton
  bool has_steepest_ = false;
  double steepest_length_ = 0, steepest_slope_ = 0, steepest_curvature_ = 0;
};

}  // namespace holdfast::detail
