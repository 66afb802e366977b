// What a descent by quadratic models asks of a linearised problem, (H + λ D) δ = −g, wherever its parts live: in one process
// (NewtonSystem) or in many (PetscSystem). Vectors are in the system's own order; of many processes, each holds its part, and sums,
// norms and costs are of all. Internal.
#pragma once

#include <holdfast/graph/graph.hpp>

namespace holdfast::detail {

class QuadraticModel {
 public:
  virtual ~QuadraticModel() = default;

  virtual std::size_t size() const = 0;
  /// H and g at these values; returns the cost.
  virtual double linearize(const Graph& graph, const Values& values, Curvature curvature) = 0;
  virtual const std::vector<double>& gradient() const = 0;
  virtual const std::vector<double>& diagonal() const = 0;                                ///< of H
  virtual void multiply(const std::vector<double>& x, std::vector<double>& y) const = 0;  ///< y = H x
  /// Solves for δ with D = diag H, or these scales. Returns the decrease of the cost that the model predicts, ½ δᵀ(λ D δ − g), or NaN where
  /// the matrix is not positive definite.
  virtual double solve_damped(double lambda, std::vector<double>& step) = 0;
  virtual double solve_damped(double lambda, const std::vector<double>& scales, std::vector<double>& step) = 0;

  virtual double cost(const Graph& graph, const Values& values) = 0;
  /// to = from ⊕ t δ.
  virtual void retract(const Values& from, double t, const std::vector<double>& step, Values& to) = 0;
  virtual double dot(const std::vector<double>& a, const std::vector<double>& b) const = 0;
  virtual double dot(const std::vector<double>& metric, const std::vector<double>& a, const std::vector<double>& b) const = 0;
  /// The factor whose residual is not finite there, in words (Resolved::first_non_finite).
  virtual std::string first_non_finite(const Graph& graph, const Values& values) const = 0;
  virtual double gradient_norm() const = 0;  ///< the largest component; NaN if there is one
};

}  // namespace holdfast::detail
