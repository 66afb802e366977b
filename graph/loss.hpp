// Robust losses. One contract for all (conventions, "Robust losses"):
//
//   a term of the cost is  w · ½ ρ(s),  s = ‖r‖² (per block) or s = r_c² summed over the components (per component);
//   ρ(0) = 0, ρ'(0) = 1, ρ' ≥ 0, ρ concave in s; the IRLS weight is ρ'(s).
//
// Thresholds are in sigmas, since r is whitened. Exceptions at 0: StudentT has ρ'(0) = (ν+d)/ν (it is the likelihood of a
// d-dimensional block), and Absolute has ρ'(0) = 1/width, since 2√s itself has no slope there.
//
//   graph.add(factor, keys, Huber{2.0});                      // per block
//   graph.add(factor, keys, per_component(Huber{2.0}));       // each component for itself, as in paper A
//   graph.add(factor, keys, one_sided(Cauchy{1.0}));          // robust only where the measurement is too long (r < 0)
#pragma once

#include <string>
#include <string_view>

namespace holdfast {

/// ρ and its first two derivatives with respect to s.
struct Rho {
  double value;
  double first;
  double second;
};

struct Loss {
  enum class Kind { Squared, Absolute, Huber, PseudoHuber, Cauchy, GemanMcClure, Welsch, Tukey, TruncatedSquares, StudentT };

  Kind kind = Kind::Squared;
  double scale = 1;            ///< the threshold [sigmas]; ν for StudentT; the smoothing width for Absolute; within 1e-100 … 1e100
  bool per_component = false;  ///< each component of the residual is a block of its own
  bool one_sided = false;      ///< squared where r > 0; needs per_component or a residual of one component

  /// ρ(s) of a block of d components (only StudentT asks for d).
  Rho rho(double s, int d = 1) const;
  /// The same for one component r of its own, which may be one-sided.
  Rho rho_of_component(double r) const { return one_sided && r > 0 ? Rho{r * r, 1, 0} : rho(r * r, 1); }

  /// ½ρ(r²) is a convex function of r: one minimum, and Newton steps descend to it.
  bool is_convex() const { return kind == Kind::Squared || kind == Kind::Absolute || kind == Kind::Huber || kind == Kind::PseudoHuber; }

  /// The same, or where it is not convex Huber with the same threshold (√ν for StudentT).
  Loss relaxed() const;

  /// Throws BadNumber where the scale breaks its rule, BadOption where one_sided has no single sign to look at.
  void validate(int residual_dim) const;
  std::string str() const;  ///< "huber:2", "cauchy:1:component:one_sided"; what parse reads
  /// Reads "huber:2", "squared", "student_t:3:component", "tukey:4.685:one_sided"; throws BadOption listing the names.
  static Loss parse(std::string_view text);

  friend bool operator==(const Loss& a, const Loss& b) {
    return a.kind == b.kind && a.scale == b.scale && a.per_component == b.per_component && a.one_sided == b.one_sided;
  }
};

/// ρ = s.
struct Squared {
  operator Loss() const { return {}; }
};
/// ρ = 2(√(s + ε²) − ε): |r| without its corner; ε = width [sigmas].
struct Absolute {
  double width = 1e-2;
  operator Loss() const { return {Loss::Kind::Absolute, width}; }
};
/// ρ = s for √s ≤ a, else 2a√s − a².
struct Huber {
  double a = 2;
  operator Loss() const { return {Loss::Kind::Huber, a}; }
};
/// ρ = 2a²(√(1 + s/a²) − 1).
struct PseudoHuber {
  double a = 2;
  operator Loss() const { return {Loss::Kind::PseudoHuber, a}; }
};
/// ρ = c² ln(1 + s/c²).
struct Cauchy {
  double c = 2;
  operator Loss() const { return {Loss::Kind::Cauchy, c}; }
};
/// ρ = c² s / (c² + s).
struct GemanMcClure {
  double c = 2;
  operator Loss() const { return {Loss::Kind::GemanMcClure, c}; }
};
/// ρ = c² (1 − exp(−s/c²)): correntropy (paper B).
struct Welsch {
  double c = 3;
  operator Loss() const { return {Loss::Kind::Welsch, c}; }
};
/// ρ = c²/3 (1 − (1 − s/c²)³) for √s ≤ c, else c²/3.
struct Tukey {
  double c = 4.685;
  operator Loss() const { return {Loss::Kind::Tukey, c}; }
};
/// ρ = min(s, c²).
struct TruncatedSquares {
  double c = 3.5;
  operator Loss() const { return {Loss::Kind::TruncatedSquares, c}; }
};
/// ρ = (ν + d) ln(1 + s/ν): the negative log-likelihood of Student's t with ν degrees of freedom, times two.
struct StudentT {
  double nu = 3;
  operator Loss() const { return {Loss::Kind::StudentT, nu}; }
};

inline Loss per_component(Loss loss) {
  loss.per_component = true;
  return loss;
}
/// For ranges without line of sight, whose measurement is only ever too long: residual (‖·‖ − d)/σ < 0.
inline Loss one_sided(Loss loss) {
  loss.one_sided = true;
  return loss;
}

}  // namespace holdfast
