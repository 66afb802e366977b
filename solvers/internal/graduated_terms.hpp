// The terms that GNC weighs: their ω, and the problem with squared terms in their place. Internal.
#pragma once

#include <holdfast/graph/resolved.hpp>
#include <holdfast/solvers/gnc.hpp>

namespace holdfast {
class Marginals;
}

namespace holdfast::detail {

class GraduatedTerms {
 public:
  /// `weights` is filled with one entry a term, ω = 1, and kept up to date. Throws BadKey where a known inlier is not in the graph.
  GraduatedTerms(const Graph& original, const Values& values, const std::vector<FactorId>& known_inliers,
                 std::vector<Gnc::TermWeight>& weights);

  const Resolved& resolved() const { return resolved_; }
  bool all_linear() const { return all_linear_; }
  bool any_truncated() const { return any_truncated_; }

  /// Whether these values satisfy the terms that GNC does not weigh: as dead reckoning does.
  bool fit_the_rest(const Graph& original, const Values& values);
  /// ω = 0 until release() for loop closures that agree with no other one. False, and nothing is held back, where too few agree.
  bool hold_back_lone_loops(const Graph& original);
  void release();
  /// Once more those that were held back.
  void hold_again();
  /// Relative poses of ω < 1/10 that are not known inliers, the smallest residual first: those that were never held back, or all where
  /// they are at most 32. None where they are less than 4 % of such loops.
  std::vector<std::size_t> doubtful_loops(const Values& values);

  /// Both μ from the largest residuals of the terms that are not held back.
  void begin(const Values& values);
  void advance(double factor);
  /// Both μ at their end: ω of the losses themselves.
  void end_graduation();
  /// All ω are 0 or 1, and widened losses are as wide as they are.
  bool arrived() const { return truncated_arrived_ && width_ <= 1; }
  /// ω at these values for the current μ; returns the largest change.
  double reweigh(const Values& values);

  /// The squared problem, without the terms of weight 0 where they are many.
  const Graph& problem();

  /// Rejected truncated terms (ω = 0) that are not far off and that the others, with what they leave open, do not contradict:
  /// ‖r‖ < kNotFar c, and rᵀ (I + J P Jᵀ)⁻¹ r <= c², P the covariance of their variables in the problem. At the values of reweigh().
  std::vector<std::size_t> compatible_rejects(const Values& values);
  /// Of these terms, those that cost less to let in than there is to gain, the cheapest first: w misfit() < Σ w ρ(s) of all weighed terms,
  /// which is what would be gained if every one of them came to fit. At the values of reweigh().
  std::vector<std::size_t> affordable(const std::vector<std::size_t>& loops, const Values& values);
  void admit(std::size_t term) { set_weight(term, 1); }
  /// All but those that are held back, whose ω is 0.
  void admit_all();

 private:
  struct Term {
    int batch, index;
    Loss loss;
    double weight;
    double slope;  ///< ρ'(0): not 1 for StudentT
    bool known;
    bool is_held = false;      ///< back
    bool was_held = false;     ///< in this solve
    bool is_loop = false;      ///< a relative pose
    bool is_harmless = false;  ///< on the squared side of a one-sided term
    double s = 0;              ///< ‖r‖², 0 on the squared side
  };
  static bool is_truncated(const Term& term) { return term.loss.kind == Loss::Kind::TruncatedSquares; }
  static bool is_near(const Term& term);  ///< a truncated one, ‖r‖ < kNotFar c
  int rows_of(const Term& term) const { return squared_.batches()[term.batch]->residual_dim(); }
  double first_width(const Term& term) const;
  void measure(const Values& values);
  void set_weight(std::size_t term, double weight);
  bool is_compatible(const Term& term, const Values& values, const Marginals& marginals) const;
  /// rᵀ (I + J P Jᵀ)⁻¹ r, P the covariance of its variables in the problem: twice what it costs to satisfy it, to first order. Infinite
  /// where there is no such covariance.
  double misfit(const Term& term, const Values& values, const Marginals& marginals) const;

  const Resolved resolved_;
  Graph squared_;
  Graph reduced_;                  ///< squared_ without the terms that are left out
  std::vector<bool> is_left_out_;  ///< of each term
  std::size_t left_out_ = 0;
  std::vector<Term> terms_;
  std::vector<Gnc::TermWeight>& weights_;
  double truncated_mu_ = 0, width_ = 1;  ///< μ of truncated squares, and of widened losses
  bool truncated_arrived_ = false;
  bool all_linear_ = true, any_truncated_ = false;
};

}  // namespace holdfast::detail
