#include <algorithm>
#include <cmath>
#include <holdfast/solvers/irls/internal/line_search.hpp>
#include <holdfast/solvers/irls/internal/workspace.hpp>

namespace holdfast {
namespace {

constexpr double kFirstDamping = 1e-12, kMostDamping = 1e9;
constexpr double kSingular =
    1e13;  // a step whose curvature is less than this part of its length² in the metric of diag H is made of rounding
constexpr double kLeastDiagonal = 1e-12;

double dot_in(const std::vector<double>& metric, const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += metric[i] * a[i] * b[i];
  return sum;
}

}  // namespace

// As Ceres moves it (Madsen, Nielsen & Tingleff 2004, §3.3).
void TrustRegion::accept(double gain_ratio, double length) {
  if (gain_ratio < 0.25)
    radius_ = 0.5 * length;
  else if (gain_ratio > 0.75)
    radius_ = std::max(radius_, 3 * length);
}

bool Irls::Workspace::find_newton_step() {
  read_diagonal();
  steepest_slope = 0;
  for (double lambda = 0; lambda <= kMostDamping; lambda = lambda == 0 ? kFirstDamping : 10 * lambda) {
    const double predicted = solve_damped(lambda);
    if (!std::isfinite(predicted)) continue;
    const double length2 = dot_in(diagonal, step, step);
    if (!(length2 <= kSingular * 2 * predicted)) continue;
    std::swap(newton, step);
    newton_length = std::sqrt(length2);
    return true;
  }
  return false;
}

// On the plane of both directions, p = a·steepest + b·newton, the model is made of six products.
Irls::Workspace::Step Irls::Workspace::take_dogleg_step(double radius) {
  const std::vector<double>& g = normal.gradient();
  const double newton_slope = dot(g, newton);
  if (newton_length <= radius) {
    step = newton;
    return {-0.5 * newton_slope, newton_length};
  }
  if (steepest_slope == 0) {
    for (std::size_t i = 0; i < g.size(); ++i) steepest[i] = -g[i] / std::max(diagonal[i], kLeastDiagonal);
    steepest_slope = dot(g, steepest);
    normal.multiply(steepest, H_steepest);
  }
  const double bent = dot(steepest, H_steepest);
  const double to_minimum = -steepest_slope / bent;
  const double length = std::sqrt(dot_in(diagonal, steepest, steepest)), cauchy = to_minimum * length;
  double a = radius / length, b = 0;
  if (cauchy < radius) {  // ‖c + b (newton − c)‖ = radius, c the minimum along the steepest direction
    const double cross = to_minimum * dot_in(diagonal, steepest, newton);
    const double A = newton_length * newton_length - 2 * cross + cauchy * cauchy, B = cross - cauchy * cauchy,
                 C = cauchy * cauchy - radius * radius;
    b = -C / (B + std::sqrt(B * B - A * C));
    a = to_minimum * (1 - b);
  }
  for (std::size_t i = 0; i < step.size(); ++i) step[i] = a * steepest[i] + b * newton[i];
  const double slope = a * steepest_slope + b * newton_slope;
  const double curvature = a * a * bent - 2 * a * b * steepest_slope - b * b * newton_slope;  // H newton = −g
  return {-slope - 0.5 * curvature, std::min(radius, newton_length)};
}

}  // namespace holdfast
