// The in-house second-order back-end: iteratively re-weighted least squares as damped Gauss–Newton on the manifold.
//
// Each iteration weighs every term by w ρ'(s) (or by Newton's curvature, Options::reweighting), builds H and g, and solves
// (H + λ D) δ = −g, D = diag(H), by sparse Cholesky. λ starts at 0 (Gauss–Newton); a step that does not lower the cost, or an H that is
// not positive definite, raises λ (Levenberg–Marquardt), and steps that the quadratic model predicted well lower it again, to 0.
// Where every factor is linear, Jacobians are computed once and residuals move along r + α J δ, so that the line search along δ
// is exact and costs next to nothing.
// Where a step fails on a graph of poses alone, the start is poor, and the valley it leads to may be, too. The chordal start
// (graph/chordal.hpp) is then tried: at once where it costs less than the best values so far, otherwise after the descent from the given
// start, and the lower end of the two is the answer (Options::restart).
// A solver object keeps the resolved problem, the ordering and the symbolic factorisation, and uses them again as long as
// neither the graph's nor the values' structure changes.
#pragma once

#include <holdfast/solvers/backend.hpp>

namespace holdfast {

class Progress;
class LinearRows;

class Irls final : public Backend {
 public:
  explicit Irls(Options chosen = {});
  ~Irls() override;
  std::string name() const override { return "irls"; }

 protected:
  Summary minimize(const Graph& graph, Values& values) override;

 private:
  struct Workspace;
  struct Fronts;
  void minimize_nonlinear(const Graph& graph, Progress& progress);
  void descend_nonlinear(const Graph& graph, Progress& progress);
  double linearize(const Graph& graph, Progress& progress);
  bool restart(const Graph& graph, Progress& progress);
  void descend_from_other_start(const Graph& graph, Progress& progress);
  bool step_nonlinear(const Graph& graph, Progress& progress, double gradient_norm, double& cost, double& predicted);
  void minimize_linear(const Graph& graph, Progress& progress);
  void minimize_rows(const Graph& graph, Values& values, Progress& progress);
  template <class Model>
  void descend(const Graph& graph, const Values& start, Model& model, Progress& progress);
  Curvature curvature(const Graph& graph, bool linear) const;

  std::unique_ptr<Workspace> workspace_;
  std::unique_ptr<LinearRows> rows_;
};

}  // namespace holdfast
