// The same graph as a ceres::Problem. Every factor is one residual block; block losses become Ceres loss functions with the same ρ
// (scaled by the weight); per-component and one-sided losses, which Ceres has not, are folded into the residual exactly:
// r̃_c = sign(r_c) √ρ(r_c²), so that ½‖r̃‖² is the cost and J̃ᵀr̃ its gradient.
// Linear solver: dense Cholesky up to 30 unknowns, else sparse Cholesky (CHOLMOD where Ceres has it).
// Ceres warns on the log (glog) of every matrix that is not positive definite, which is part of finding the first trust region. The log is
// the program's: set its level there (FLAGS_minloglevel, or GLOG_minloglevel in the environment).
#pragma once

#include <holdfast/solvers/backend.hpp>

namespace holdfast {

struct CeresVariant {
  const char* name;
  double trust_region_radius;  ///< of the first step; 1e32: Gauss–Newton until a step fails
  bool dogleg;
};

/// "ceres" is Ceres at its best on the problems of this field; the others are there to compare with.
inline constexpr CeresVariant kCeresVariants[] = {{"ceres", 1e32, false}, {"ceres-lm", 1e4, false}, {"ceres-dogleg", 1e4, true}};

std::unique_ptr<Backend> make_ceres(const CeresVariant& variant, const Options& options);

/// What Ceres itself finds at these values, the gradient in Resolved's tangent: the conformance tests compare it with holdfast::gradient.
struct CeresEvaluation {
  double cost = 0;
  std::vector<double> gradient;
};
CeresEvaluation evaluate_with_ceres(const Graph& graph, const Values& values);

}  // namespace holdfast
