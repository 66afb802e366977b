#include <holdfast/solvers/irls/internal/geodesic.hpp>

namespace holdfast::detail {

Geodesic::Geodesic(const Graph& graph, const NewtonSystem& system) : gradients_(graph), offsets_(tangent_offsets(system.resolved())) {
  for (std::vector<double>* v : {&ahead_, &curvature_, &rhs_, &acceleration_}) v->resize(system.size());
}

bool Geodesic::bend(const Graph& graph, NewtonSystem& system, const Values& at, const std::vector<double>& step,
                    std::vector<double>& tangent, Values& moved) {
  constexpr double h = 0.1;
  constexpr double kMostBend = 0.25;  // ‖a‖ / ‖δ‖
  for (std::size_t i = 0; i < tangent.size(); ++i) ahead_[i] = h * tangent[i];
  system.resolved().retract(at, ahead_.data(), moved);
  gradients_.curvature(graph, system.resolved(), at, moved, h, tangent.data(), offsets_, curvature_, &system.pool());
  system.from_tangent(curvature_, rhs_);
  for (double& x : rhs_) x = -x;
  system.solve_again(rhs_, acceleration_);
  const double a2 = dot(system.diagonal(), acceleration_, acceleration_), d2 = dot(system.diagonal(), step, step);
  if (!(a2 <= kMostBend * kMostBend * d2)) return false;
  for (std::size_t i = 0; i < step.size(); ++i) acceleration_[i] = step[i] + 0.5 * acceleration_[i];
  system.to_tangent(acceleration_, tangent);
  return true;
}

}  // namespace holdfast::detail
