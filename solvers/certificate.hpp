// Is it the global minimum? A lower bound of the cost over all values, and its distance from the cost of an answer.
//
//   const Certificate c = certify(graph, answer);
//   if (c.is_global()) …                              // no values whatever have a cost lower than (1 − c.relative_gap()) c.cost
//
// Which terms count. Relative poses (factors that say relative_pose(): Between<Pose2>, Between<Pose3>, with any information matrix) under
// the squared loss. Every other term, a prior, a range, a robust loss, counts as 0, which no term falls short of: the bound stays true, and
// is loose by what those terms cost at the minimum. So a pose graph held by a fixed pose, or by a prior that is met, gets a tight
// bound; a range graph does not. A graph whose Graph::relaxed() is convex (positions and ranges under convex losses) gets the cost of that
// relaxation, if that is higher: to the tolerance it is solved with, and usually loose. Of a GNC answer certify the graph of its inliers.
//
// How. Every cost is replaced by a quadratic function of the rows Z = [R₁ᵀ; p₁ᵀ; …] below it, equal to it and with the same gradient at the
// answer X (solvers/internal/pose_minorant.hpp: θ² is convex in 1 − cos θ, ½eᵀΛe in e). Their sum m(Z) = c + ½⟨Z, Q Z⟩ is what the
// verification of SE-Sync (Rosen, Carlone, Bandeira & Leonard, IJRR 2019) is for. R_iᵀR_i = I gives it multipliers in closed form,
//
//   Λ_i = sym((Q X)_i R_i),     S = Q − diag(Λ),     E = S X       (E = 0 at a critical point)
//
// For any other values Z let W = Z − X, zero at the poses that are held (fixed; where none is, one pose of each connected part, as
// moving all of it costs nothing). Then m(Z) = m(X) + ⟨W, E⟩ + ½⟨W, S W⟩ exactly, so with S positive definite on what is free
//
//   f(Z) ≥ m(Z) ≥ m(X) − ½⟨E, S⁻¹E⟩        for all Z
//
// One sparse Cholesky factorisation decides, and its margin of 16 roundings of each diagonal entry makes its yes a proof up to rounding.
// It is holdfast's own cost that is bounded, geodesic and with full information matrices; no conversion, no polish.
//
// Where S is not positive definite the answer may still be the minimum: the multipliers do not show it. The bound is then
// m(X) − ½⟨E, S_η⁻¹E⟩ − 4 η (poses), S_η = S + η on rotations, with the least η that serves (inverse iterations and factorisations).
// A chordal cost with weights small enough to lie below every term gives another bound, and the higher of the two is it.
// And the classical question is asked, too: every information matrix becomes diag(τI, κI) (harmonic means of the eigenvalues of
// its blocks; cross blocks are dropped), 1 − cos θ takes the place of ½θ² (the chordal cost), a few Newton steps go from the answer to
// the minimum of that, and the same test is made there. Its yes, Verdict::chordal_minimum, certifies that other cost and says how far its
// minimum is from the answer: information that is not isotropic weighs directions differently, so the two minima differ, and
// the order of the costs of two far minima may, too.
//
// Cost: about one linearisation and one factorisation of the problem, with n + 1 rows a pose. No threads.
#pragma once

#include <holdfast/solvers/backend.hpp>
#include <limits>

namespace holdfast {

struct CertificateOptions {
  double tolerance = 1e-7;     ///< > 0: the gap, relative to the cost, of a certified minimum
  bool ask_chordal = true;     ///< where the graph's own cost could not be certified and no term was left out
  bool ask_relaxation = true;  ///< where the relaxation is convex

  /// Throws BadOption with field, value and rule.
  void validate() const;
};

struct Certificate {
  enum class Verdict {
    global_minimum,   ///< of the graph's own cost: gap ≤ tolerance · cost
    chordal_minimum,  ///< of the chordal cost with isotropic weights alone, near the answer
    not_certified     ///< neither shown nor refuted
  };
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

  Verdict verdict = Verdict::not_certified;
  double cost = 0;   ///< Graph::cost at the answer
  double bound = 0;  ///< no values have a cost below it; ≥ 0
  double gap() const { return cost - bound; }
  double relative_gap() const { return cost > 0 ? gap() / cost : 0; }
  bool is_global() const { return verdict == Verdict::global_minimum; }

  bool positive_definite = false;  ///< S on what is free
  double eta = 0;                  ///< the shift that the bound needed; 0: none
  bool is_isotropic = true;        ///< every information matrix is diag(τI, κI)
  std::size_t terms = 0;           ///< relative poses under the squared loss
  std::size_t left_out = 0;        ///< terms that count as 0 in the bound
  double left_out_cost = 0;        ///< of them, at the answer: part of the gap
  std::string left_out_first;      ///< the first of them, as "Range(A11, L0)"
  double relaxation = kUnknown;    ///< cost of the convex relaxation, where it was asked

  // Of the chordal question, where it was asked.
  double chordal_cost = kUnknown, chordal_bound = kUnknown;  ///< at the chordal minimum nearby
  double chordal_move = kUnknown;                            ///< [m] the largest distance between a pose's position there and in the answer
  double chordal_turn = kUnknown;                            ///< [rad] the largest angle

  int factorizations = 0;
  double seconds = 0;
  double tolerance = 0;  ///< that was asked for
  std::string str() const;
};

/// Values need not be an answer: far from a minimum the gap says so. Throws BadOption, BadProblem (no factor), BadKey, BadType, BadNumber
/// (a residual that is not finite, names the factor).
Certificate certify(const Graph& graph, const Values& values, const CertificateOptions& options = {});

const char* to_string(Certificate::Verdict verdict);

}  // namespace holdfast
