// A solve that ends in a minimum: where a back-end stops at a saddle or at a zero distance, it is left, and solved again.
//
//   auto backend = make_backend("irls");
//   const SecondOrder end = second_order(graph, values, *backend);
//   end.verdict                                  // minimum, left_saddle (a minimum, too), or not_checked: end.why says why
//
// A start in the plane or on the line of all range anchors, or several agents in one point, has a gradient of zero across it: every
// back-end stops there and says "converged", at any cost. Round any back-end:
//
//   1. the back-end solves;
//   2. the sign of the curvature at its answer x. Lanczos with full orthogonalisation on ∇²f v = θ M v, at most lanczos_steps of them:
//      ∇²f v = (g(x ⊕ hv) − g(x ⊖ hv)) / 2h, g the exact gradient of Graph::cost, robust losses included; M = H + λ D the model of
//      iteratively re-weighted least squares, factored. So θ ≤ 1 where residuals are small, and what the model does not see (a saddle,
//      and a cusp at zero distance most of all) stands far outside on the left, where Lanczos goes first. It ends as soon as a negative
//      eigenvalue would have shown: its part in a random vector is 1/√n or so, and grows with every step by a factor that follows from
//      how far it lies outside of the others (Kuczyński, Woźniakowski 1992).
//      M is at first what irls has at hand from its last step, and the difference is one-sided: that says "minimum" in most solves.
//      Where it does not, M is made anew at x, with a little damping, and differences are central;
//   3. θ < −curvature_tolerance, and a step along v or −v, long or short, has a lower cost: the best of them is the next start. Back to 1.
//
// What it is not: a proof. The least θ of a few Lanczos steps from one pseudo-random vector (always the same one) is an upper bound of the
// least. A direction that bends down by less than curvature_tolerance · vᵀMv is taken for flat. A minimum may be a local one.
// Cost of a check after irls: one gradient and one substitution a Lanczos step, of which there are three where all is well; after others
// an ordering and a factorisation, too. It allocates. Nothing in the library calls it unasked; the program's solve does where
// may_hide_saddles().
#pragma once

#include <holdfast/solvers/backend.hpp>

namespace holdfast {

struct SecondOrderOptions {
  int lanczos_steps = 12;             ///< >= 1; fewer where the problem has fewer unknowns
  double curvature_tolerance = 1e-4;  ///< in (0, 1)
  int max_saddles = 20;               ///< >= 0: how many are left before it gives up; 0: checked, never left

  /// Throws BadOption with field, value and rule.
  void validate() const;
};

struct SecondOrder {
  using Verdict = Minimum;
  Verdict verdict = Verdict::not_checked;
  std::string why;           ///< of not_checked
  int saddles = 0;           ///< left
  double curvature = 0;      ///< the least θ found at the answer; 0 where not checked
  double seconds_check = 0;  ///< of 2 and 3, all of them
  Summary summary;           ///< of the last solve; cost_first is the start's, iterations, restarts and seconds are of all solves
  std::string str() const;
};

/// Throws what Backend::solve throws, and BadOption. Values are unchanged where it fails (summary.usable() is false); the cost never rises
/// from one solve to the next. The back-end's time_limit holds for each solve.
SecondOrder second_order(const Graph& graph, Values& values, Backend& backend, const SecondOrderOptions& options = {});

/// The same where `values` is an answer already, and `solved` says how it was found; `backend` solves again from where a saddle was left.
SecondOrder second_order_from(const Graph& graph, Values& values, Backend& backend, Summary solved, const SecondOrderOptions& options = {});

/// True where some factor is not linear and has fewer residuals than one of its variables has unknowns (ranges, bearings, landmarks,
/// positions): where a start in a plane, on a line or in one point hides a direction from every gradient.
bool may_hide_saddles(const Graph& graph);

}  // namespace holdfast
