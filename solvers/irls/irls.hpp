// The in-house second-order back-end: iteratively re-weighted least squares as damped Gauss–Newton on the manifold.
//
// Each iteration weighs every term by w ρ'(s) (or by Newton's curvature, IrlsOptions::reweighting), builds H and g, and factors H once, by
// sparse Cholesky. The step is Powell's dogleg: H δ = −g in full as long as steps do what the model says (Gauss–Newton), bent
// towards −D⁻¹g, D = diag H, where they do not; a step that fails costs one evaluation, not a factorisation. Where residuals are
// curved, the step follows them to second order (geodesic acceleration). An H that is not positive definite is damped by λ D.
// Where every factor is linear, Jacobians are computed once and residuals move along r + α J δ, so that the line search along δ
// is exact and costs next to nothing.
// Where a step fails, or lowers the cost by less than half or more than one and a half times what the model said, on a graph of poses
// alone, the start is poor, or the valley is. The chordal start (graph/starts/chordal.hpp) is then tried: at once where it costs less than
// the best values so far, otherwise after the descent from the given start, and the lower end of the two is the answer
// (IrlsOptions::restart). A solver object keeps the resolved problem, the ordering and the symbolic factorisation, and uses them again as
// long as neither the graph's nor the values' structure changes.
#pragma once

#include <holdfast/solvers/backend.hpp>
#include <memory>

namespace holdfast {

namespace detail {
class LinearRows;
}

/// How the in-house second-order back-end weighs robust terms in its quadratic model (the gradient is exact either way).
///   irls:      w ρ'(s): a model that never lies below the cost near by; linear convergence.
///   newton:    w (ρ' + 2sρ''), cut off below: few iterations, kept descending by a line search.
///   automatic: newton where all losses are convex and all factors linear, else irls; and where all losses and factors are convex and some
///              say hessian() (RangeBall, MissingDistance): a semismooth Newton method with these Hessians, damped, with a line search.
enum class Reweighting { automatic, irls, newton };

/// What only this back-end has.
struct IrlsOptions {
  Reweighting reweighting = Reweighting::automatic;
  bool restart = true;  ///< on a pose graph where Gauss–Newton fails or is far off its model, try the chordal start, too
};

class Irls final : public Backend {
 public:
  explicit Irls(Options chosen = {}, IrlsOptions of_irls = {});
  ~Irls() override;
  std::string name() const override { return "irls"; }

  detail::NewtonSystem* last_system(const Graph& graph, const Values& values) override;

  IrlsOptions irls_options;

 protected:
  Summary minimize(const Graph& graph, Values& values) override;

 private:
  struct Workspace;
  Curvature curvature(const Graph& graph, bool linear) const;

  std::unique_ptr<Workspace> workspace_;
  std::unique_ptr<detail::LinearRows> rows_;
};

}  // namespace holdfast
