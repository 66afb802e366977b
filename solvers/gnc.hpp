// Graduated non-convexity (Yang, Antonante, Tzoumas & Carlone, "Graduated Non-Convexity for Robust Spatial Perception", RA-L 2020) round
// any back-end: finds a good minimum of truncated and redescending losses without a good start.
//
//   auto backend = gnc(make_backend("irls"));
//   Summary s = backend->solve(graph, values);
//   for (const Gnc::TermWeight& t : backend->weights()) …   // which measurements were believed
//
// Terms whose loss is not convex (Loss::is_convex; users' own, too), as a block or of one component, become squared terms with a weight ω
// that starts at 1; other terms stay as they are. TruncatedSquares{c} (GNC-TLS), with u = ‖r‖²/c²:
//
//   ω = 1 for u ≤ μ/(μ+1), 0 for u ≥ (μ+1)/μ, else √(μ(μ+1)/u) − μ;   μ ← μ · mu_factor from 1/(2 u_max − 1)   until all ω are 0 or 1
//
// Every other loss is widened to μ ρ(s/μ), which goes to s as μ grows. With s = ‖r‖²:
//
//   ω = ρ'(s/μ) / ρ'(0);   μ ← μ / mu_factor from where the least ω is about 4/9   until μ = 1: ω = ρ'(s) / ρ'(0)
//
// For GemanMcClure{c} that is GNC-GM: ω = (μ/(u+μ))² from μ = 2 u_max. u_max: the largest u of these terms. One-sided terms keep ω = 1 on
// their squared side (r > 0).
//
// Where it differs from the paper, which solves with all ω = 1 first and goes on from there: false loops at full weight fold the map, and
// it stays folded.
//   1. A start that satisfies the other terms (2 sigmas, root mean square), as dead reckoning does, is trusted: the first ω come from its
//      residuals, and the weighted problems are solved afresh from it.
//   2. From such a start, loop closures that no other one agrees with wait until the others have been graduated
//      (solvers/internal/agreeing_loops.hpp): random false loops agree with nobody. `pairs` turns it off.
//   3. Terms with ω = 0 are not in the problem that the inner back-end gets, so that they cost nothing.
//   4. At the end all terms are weighed by the losses themselves, also those that waited, until the weights no longer change, or
//      Graph::cost changes by no more than cost_tolerance of it. Then a second look: rejected terms with ‖r‖ < 2c that all others, with the
//      uncertainty they leave, do not contradict at c, are let in where Graph::cost is lower for it.
//   5. Second chances, where at least 4 % of the loop closures that were not held back in 2 are rejected (or of all, where at most 32 are):
//      graduation begins once more from the chordal start of the problem without the loops held back; then such loops are let in at full
//      weight one by one, until 16 have been in vain, at most 64 in all. To let a loop in costs ½ rᵀ(I + JPJᵀ)⁻¹r to first order, P the
//      covariance that the believed terms leave: only loops that cost less than all terms of a relaxed loss cost now are tried, the
//      cheapest first, and where they are more than four a trial that is not lower after 20 steps is given up. Whatever ends at a lower
//      Graph::cost is kept. `second_chances` turns it off.
#pragma once

#include <holdfast/solvers/backend.hpp>
#include <holdfast/solvers/detail/clock.hpp>

namespace holdfast {

struct GncOptions {
  double mu_factor = 3;                 ///< > 1
  bool pairs = true;                    ///< of loop closures, those that agree with another one come first
  bool second_chances = true;           ///< other starts, and rejected loops let in on trial
  int max_outer_iterations = 100;       ///< >= 1: solves of the inner back-end, second chances apart
  std::vector<FactorId> known_inliers;  ///< of the graph to solve: ω = 1 throughout

  /// Throws BadOption with field, value and rule.
  void validate() const;
};

/// Options: those of the inner back-end at first. max_iterations holds for each inner solve, time_limit and the progress callback (called
/// once an outer iteration) for the whole.
class Gnc final : public Backend {
 public:
  /// Throws BadOption: no inner back-end, or options that break their rules.
  Gnc(std::unique_ptr<Backend> inner, GncOptions chosen);
  std::string name() const override { return "gnc-" + inner_->name(); }
  Backend& near_answer() override { return *inner_; }

  struct TermWeight {
    FactorId id;
    double weight;  ///< ω in [0, 1]
  };
  /// Of every term that GNC weighs (known inliers among them) after the last solve, in the graph's order.
  const std::vector<TermWeight>& weights() const { return weights_; }
  /// Of one of them. Throws BadKey for any other factor.
  double weight(FactorId id) const;

  GncOptions gnc_options;

 protected:
  /// The summary is scored by Graph::cost of the graph itself. An answer that costs more than the start is dropped for the start, and the
  /// summary says so (weights() are those that led to it). Throws BadKey where a known inlier is not in the graph.
  Summary minimize(const Graph& graph, Values& values) override;

 private:
  class Run;
  Summary solve_inner(const Graph& problem, Values& x, const Stopwatch& watch, double tolerance, int most_iterations = 0);

  std::unique_ptr<Backend> inner_;
  std::vector<TermWeight> weights_;
};

std::unique_ptr<Gnc> gnc(std::unique_ptr<Backend> inner, GncOptions options = {});

}  // namespace holdfast
