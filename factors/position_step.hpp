// Random walk of a position:   r = (p_b − p_a) / beta,   beta [m] one sigma of a step per axis          (paper C, eq. 9)
//
// A is the earlier, B the later variable; anything with a position. Its mean step is zero: a target that moves steadily is better
// described by white_acceleration.
#pragma once

#include <holdfast/factors/detail/displacement.hpp>
#include <holdfast/graph/batch.hpp>
#include <holdfast/graph/require.hpp>
#include <holdfast/graph/variables.hpp>

namespace holdfast {

template <class A, class B>
struct PositionStep {
  double beta;  ///< [m]

  using Variables = variables<A, B>;
  static constexpr int residual_dim = space_dim<A>;
  static constexpr bool is_linear = true;  // for poses, too: the position is linear in every tangent
  static const char* name() { return "PositionStep"; }
  static constexpr auto fields() { return std::tuple(field("beta", &PositionStep::beta)); }

  Vector<residual_dim> operator()(const A& a, const B& b, Jacobians<PositionStep>* J = nullptr) const {
    if (J != nullptr) set_displacement_jacobian(Matrix<residual_dim, residual_dim>::Identity() / beta, *J);
    return displacement(a, b) / beta;
  }

  Vector<residual_dim> raw(const Vector<residual_dim>& r) const { return beta * r; }  ///< [m]
  void validate() const { require_positive("PositionStep.beta", beta); }
};

// Compiled into the library (factors/compiled.cpp), not anew by whoever adds them to a graph.
extern template class Batch<PositionStep<Point2, Point2>>;

}  // namespace holdfast
