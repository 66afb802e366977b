#include <algorithm>
#include <cmath>
#include <holdfast/solvers/irls/internal/dogleg.hpp>
#include <holdfast/solvers/linear/internal/damping.hpp>

namespace holdfast::detail {
namespace {

constexpr double kFirstDamping = 1e-12, kMostDamping = 1e9;
constexpr double kSingular = 1e13;  // a step whose curvature is less than 1/kSingular of its length² in the metric of D is rounding
constexpr double kFull = 0.1;       // a step shorter than this part of Newton's is short because of the radius

}  // namespace

// As Ceres moves it (Madsen, Nielsen & Tingleff 2004, §3.3).
void TrustRegion::accept(double gain_ratio, double length) {
  if (gain_ratio < 0.25)
    radius_ = 0.5 * length;
  else if (gain_ratio > 0.75)
    radius_ = std::max(radius_, 3 * length);
}

Dogleg::Dogleg(const QuadraticModel& system) {
  for (std::vector<double>* v : {&newton_, &steepest_, &H_steepest_}) v->resize(system.size());
}

bool Dogleg::begin(QuadraticModel& system) {
  has_steepest_ = false;
  for (double lambda = 0; lambda <= kMostDamping; lambda = lambda == 0 ? kFirstDamping : 10 * lambda) {
    const double predicted = system.solve_damped(lambda, newton_);
    if (!std::isfinite(predicted)) continue;
    const double length2 = system.dot(system.diagonal(), newton_, newton_);
    if (!(length2 <= kSingular * 2 * predicted)) continue;
    newton_length_ = std::sqrt(length2);
    newton_slope_ = system.dot(system.gradient(), newton_);
    return true;
  }
  return false;
}

void Dogleg::find_steepest(const QuadraticModel& system) {
  const std::vector<double>&g = system.gradient(), &D = system.diagonal();
  for (std::size_t i = 0; i < g.size(); ++i) steepest_[i] = -g[i] / std::max(D[i], kLeastDiagonal);
  system.multiply(steepest_, H_steepest_);
  steepest_slope_ = system.dot(g, steepest_);
  steepest_curvature_ = system.dot(steepest_, H_steepest_);
  steepest_length_ = std::sqrt(system.dot(D, steepest_, steepest_));
  has_steepest_ = true;
}

Dogleg::Step Dogleg::take(const QuadraticModel& system, double radius, std::vector<double>& step) {
  if (newton_length_ <= radius) {
    step = newton_;
    return {-0.5 * newton_slope_, newton_length_, true};
  }
  if (!has_steepest_) find_steepest(system);
  const double to_minimum = -steepest_slope_ / steepest_curvature_, cauchy = to_minimum * steepest_length_;
  if (cauchy >= radius) return combine(radius / steepest_length_, 0, radius, step);
  // ‖c + b (newton − c)‖ = radius, c the minimum along the steepest direction.
  const double cross = to_minimum * system.dot(system.diagonal(), steepest_, newton_);
  const double A = newton_length_ * newton_length_ - 2 * cross + cauchy * cauchy, B = cross - cauchy * cauchy,
               C = cauchy * cauchy - radius * radius;
  const double b = -C / (B + std::sqrt(B * B - A * C));
  return combine(to_minimum * (1 - b), b, radius, step);
}

// On the plane of both directions the model is made of six products; H newton = −g.
Dogleg::Step Dogleg::combine(double a, double b, double length, std::vector<double>& step) const {
  for (std::size_t i = 0; i < step.size(); ++i) step[i] = a * steepest_[i] + b * newton_[i];
  const double slope = a * steepest_slope_ + b * newton_slope_;
  const double curvature = a * a * steepest_curvature_ - 2 * a * b * steepest_slope_ - b * b * newton_slope_;
  return {-slope - 0.5 * curvature, length, length >= kFull * newton_length_};
}

}  // namespace holdfast::detail
