// A rival for convex problems: FISTA (Beck & Teboulle 2009) with adaptive restart (O'Donoghue & Candès 2015), plain but for a diagonal
// metric.
#pragma once

#include <holdfast/solvers/backend.hpp>

namespace holdfast::bench {

/// x⁺ = y ⊖ D⁻¹∇f(y), y = x⁺ ⊕ (t − 1)/t⁺ (x⁺ ⊖ x). D: of each variable twice the largest row sum of Σ w ρ'(0) JᵀJ where the factors are
/// steepest (a RangeBall's curvature is at most that of the distance itself), so that no step length has to be searched where every
/// factor ties two points; L grows where that was too little.
class Fista final : public Backend {
 public:
  explicit Fista(Options chosen) : Backend(std::move(chosen)) {}
  std::string name() const override { return "fista"; }

 protected:
  Summary minimize(const Graph& graph, Values& values) override;
};

}  // namespace holdfast::bench
