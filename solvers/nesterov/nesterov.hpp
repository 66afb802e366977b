// The in-house first-order back-end: Nesterov's accelerated gradient (paper C (38)(39)), with what makes it work where
// (35)–(37) do not:
//   y⁰ = x⁰;   x^{k+1} = y^k ⊕ −(1/L) P⁻¹ ∇f(y^k);   y^{k+1} = x^{k+1} ⊕ β_k (x^{k+1} ⊖ x^k),
//   β_k = (t_k − 1)/t_{k+1},   t_{k+1} = (1 + √(1 + 4t_k²))/2
// * P: per agent, the block-tridiagonal part of H = Σ w ρ'(0) JᵀJ along its own chain of variables, rounded towards a multiple of the
//   identity where L shows that the cost curves more than JᵀJ says (a range bends sideways);
// * L by backtracking: f(x^{k+1}) ≤ f(y^k) − ‖∇f(y^k)‖²_{P⁻¹} / 2L;
// * momentum restarts when it points uphill (O'Donoghue & Candès 2015) or would raise the cost: the cost never rises;
// * ⊕ is the manifold's retraction.
// Each agent needs only its neighbours' values and gradients.
#pragma once

#include <holdfast/solvers/backend.hpp>

namespace holdfast {

class Nesterov final : public Backend {
 public:
  explicit Nesterov(Options chosen = {});
  ~Nesterov() override;
  std::string name() const override { return "nesterov"; }

 protected:
  Summary minimize(const Graph& graph, Values& values) override;

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace holdfast
