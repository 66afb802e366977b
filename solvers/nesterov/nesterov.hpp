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
//
// Where every factor and loss is convex and all variables are of vector spaces, the same sequences need one gradient an iteration and no
// search for L: what two gradients show of it is enough. P is then H = Σ w ρ'(0) JᵀJ of all factors where each is steepest, once; by
// default the whole of it, factored by sparse Cholesky (NesterovOptions::metric).
#pragma once

#include <holdfast/solvers/backend.hpp>

namespace holdfast {

/// What only this back-end has.
struct NesterovOptions {
  /// Of convex problems. whole: H ≼ P, fewest iterations. chains: per agent, so that agents exchange nothing but what their neighbours'
  /// gradients need; more iterations.
  enum class Metric { whole, chains };
  Metric metric = Metric::whole;
};

class Nesterov final : public Backend {
 public:
  explicit Nesterov(Options chosen = {}, NesterovOptions of_nesterov = {});
  ~Nesterov() override;
  std::string name() const override { return "nesterov"; }

  NesterovOptions nesterov_options;

 protected:
  Summary minimize(const Graph& graph, Values& values) override;

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace holdfast
