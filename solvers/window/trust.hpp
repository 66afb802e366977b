// Who is to be believed just now. A loss looks at one measurement at a time; a burst in which an agent receives nothing but outliers, or a
// beacon whose every range lies, shows only in many. Trust counts, for each party (an agent, a beacon), how many of its latest measurements
// fit, and says when to stop believing it, and when to begin again.
//
//   Trust trust;
//   … window.add(range, {A(7), L(0)}, TruncatedSquares{3}) … window.step(now) …
//   const bool fits = trust.fits(squared_norm_of_residual, dim);                     // of a measurement in the window: at the answer
//   const bool would = trust.fits(innovation(one, window.values(), marginals), dim); // of one that is withheld: given what is known
//   switch (trust.judge(party, ticket, fits)) {
//     case Trust::Change::lost: …      // take doubtful(party) out of the window, and withhold what it measures from now on
//     case Trust::Change::regained: …  // put those of latest(party) that fit into the window again, under a convex loss, or disbelieve()
//   }
//
//   fits        ‖r‖² ≤ gate² + 2.4 (dim − 1); withheld: rᵀ (I + J P Jᵀ)⁻¹ r in its place, P the covariance of what is known without it
//   lost        fewer than `lost` of the `recent` latest fit
//   regained    at least `regained` of the `recent` latest fit
//
// While a party is not believed its state goes on by its motion, P grows, and with it what fits: honest covariances cannot lock it out.
// In the end nearly everything fits by itself; so before it is believed again its latest measurements are to be tried together: solve for
// them, and see whether as many fit within the plain gate (disbelieve() where they do not). A measurement between two parties is judged
// for both as long as both are believed, else for those that are not: so of an agent in a burst only the agent is accused, and a beacon
// that lies is named and the agent is not.
#pragma once

#include <cstdint>
#include <deque>
#include <holdfast/graph/graph.hpp>
#include <holdfast/solvers/marginals.hpp>
#include <map>

namespace holdfast {

struct TrustOptions {
  int recent = 8;          ///< >= 2 measurements
  double gate = 3;         ///< > 0 [sigmas]
  double lost = 0.5;       ///< in (0, 1)
  double regained = 0.75;  ///< in [lost, 1]

  /// Throws BadOption with field, value and rule.
  void validate() const;
};

class Trust {
 public:
  enum class Change { none, lost, regained };
  struct Judged {
    std::uint64_t ticket;
    bool fits;
  };

  /// Throws BadOption.
  explicit Trust(TrustOptions options = {});

  bool fits(double squared_norm, int dim) const { return squared_norm <= options_.gate * options_.gate + 2.4 * (dim - 1); }
  /// One more measurement of this party. ticket: the caller's name of it.
  Change judge(std::uint64_t party, std::uint64_t ticket, bool fits);
  bool is_believed(std::uint64_t party) const;
  /// After Change::regained, where its measurements do not fit together after all.
  void disbelieve(std::uint64_t party) { parties_[party].is_believed = false; }
  /// Its latest measurements, oldest first.
  std::vector<Judged> latest(std::uint64_t party) const;
  /// Of them, those since the first that did not fit.
  std::vector<Judged> doubtful(std::uint64_t party) const;
  /// Those that are not believed, ascending.
  std::vector<std::uint64_t> disbelieved() const;

  const TrustOptions& options() const { return options_; }

  /// All that it remembers, for files.
  struct Party {
    bool is_believed = true;
    std::deque<Judged> latest;
  };
  const std::map<std::uint64_t, Party>& parties() const { return parties_; }
  void set_parties(std::map<std::uint64_t, Party> parties) { parties_ = std::move(parties); }

 private:
  TrustOptions options_;
  std::map<std::uint64_t, Party> parties_;
};

/// rᵀ (I + J P Jᵀ)⁻¹ r of the one factor of `one`, on one or two variables, at these values; P: their covariance by `marginals`. 0 where
/// one of them is not observable: nothing is known that it could contradict. Throws BadProblem where `one` has not one factor on one or two
/// variables; BadKey, BadType.
double innovation(const Graph& one, const Values& values, const Marginals& marginals);

}  // namespace holdfast
