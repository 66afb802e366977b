#include <algorithm>
#include <cmath>
#include <holdfast/graph/gradient.hpp>
#include <holdfast/graph/starts/chordal.hpp>
#include <holdfast/solvers/gnc.hpp>
#include <holdfast/solvers/internal/graduated_terms.hpp>
#include <holdfast/solvers/internal/minimizer.hpp>

namespace holdfast {
namespace {

constexpr double kLoose = 1e-6;     // cost_tolerance of trials, at least
constexpr double kOnTheWay = 1e-4;  // of the graduation's solves, whose weights are not the last ones
constexpr double kByChance = 1e-3;  // of those from the chordal start
constexpr int kFewSteps = 20;       // of an inner solve that may be in vain
constexpr int kSecondLooks = 3;
constexpr std::size_t kFewTrials = 4;  // that are followed to their end
constexpr int kMostInVain = 16;        // one after the other
constexpr int kMostTrials = 64;        // of second chances
constexpr int kMostSolves = 12;        // in each, until the weights no longer change
constexpr double kLower = 1 - 1e-6;    // a cost that is worth it

}  // namespace

void GncOptions::validate() const {
  if (!(mu_factor > 1 && std::isfinite(mu_factor)))
    fail<BadOption>("mu_factor = ", mu_factor, " must be finite and > 1; the paper's is 1.4");
  if (max_outer_iterations < 1) fail<BadOption>("max_outer_iterations = ", max_outer_iterations, " must be >= 1");
}

// One solve of GNC.
class Gnc::Run {
 public:
  Run(Gnc& gnc, const Graph& graph, const Values& start, const Options& outer)
      : progress(outer, outer.max_iterations),
        gnc_(gnc),
        graph_(graph),
        start_(start),
        x_(start),
        terms_(graph, start, gnc.gnc_options.known_inliers, gnc.weights_) {}

  Summary minimize(Values& values) {
    progress.watch.lap(summary().seconds_setup);
    if (!progress.begin(terms_.resolved().cost(graph_, start_), graph_, terms_.resolved(), start_)) return std::move(summary());
    cost_ = summary().cost;
    summary().gradient_norm = max_norm(gradient(graph_, start_).value);
    if (graduate() && settle()) {
      look_again();
      if (gnc_.gnc_options.second_chances && summary().usable()) second_chances();
    }
    finish(values);
    return std::move(summary());
  }

  Progress progress;

 private:
  Summary& summary() { return progress.summary; }

  // Every problem on the way is solved afresh from a start that is as good as dead reckoning: what the one before has bent stays bent.
  bool graduate() {
    const bool start_is_good = terms_.fit_the_rest(graph_, start_);
    const bool held = start_is_good && gnc_.gnc_options.pairs && terms_.hold_back_lone_loops(graph_);
    const bool afresh = start_is_good && !held && !terms_.all_linear();
    if (!start_is_good && !solve(kLoose)) return false;
    terms_.begin(x_);
    for (;;) {
      terms_.reweigh(x_);
      const bool arrived = terms_.arrived();
      if (afresh) x_.assign(start_);
      if (!solve(kOnTheWay)) return false;
      if (arrived) break;
      terms_.advance(gnc_.gnc_options.mu_factor);
    }
    terms_.release();
    terms_.end_graduation();
    return true;
  }

  // The losses themselves, by their weights, until these no longer change.
  bool settle(bool is_solved = false) {
    for (int solves = is_solved ? 1 : 0;; ++solves) {
      const double change = terms_.reweigh(x_), before = cost_;
      if (change == 0 && solves > 0) return ends("the weights of GNC no longer change");
      if (!solve(gnc_.options.cost_tolerance)) return false;
      if (solves > 0 && std::abs(before - cost_) <= gnc_.options.cost_tolerance * before)
        return ends("the relative change of the cost is within cost_tolerance");
    }
  }

  // What was rejected on the way and now nearly fits is let in where the cost is the lower for it.
  void look_again() {
    for (int looks = 0; looks < kSecondLooks && terms_.any_truncated(); ++looks) {
      const std::vector<std::size_t> admitted = terms_.compatible_rejects(x_);
      if (admitted.empty()) return;
      const Values before = x_;
      const double cost = cost_;
      const char* const rule = summary().rule;
      for (const std::size_t term : admitted) terms_.admit(term);
      if (solve(gnc_.options.cost_tolerance) && settle(true) && cost_ < cost * (1 - 1e-9)) continue;
      x_.assign(before);
      cost_ = cost;
      terms_.reweigh(x_);
      if (summary().usable()) ends(rule);
      return;
    }
  }

  // What agreed with others and was rejected all the same: by a false loop or a fold that came first.
  void second_chances() {
    if (terms_.doubtful_loops(x_).empty()) return;
    from_chordal();
    int trials = 0;
    for (bool is_better = true; is_better;) {
      is_better = false;
      int in_vain = 0;
      const std::vector<std::size_t> loops = terms_.affordable(terms_.doubtful_loops(x_), x_);
      const bool patient = loops.size() <= kFewTrials;
      for (const std::size_t loop : loops) {
        if (is_better || ++in_vain > kMostInVain || ++trials > kMostTrials || is_over_) break;
        is_better = keeps_if_lower([&] { return (is_lower_with(loop) || patient) && try_settle(); });
      }
    }
  }

  /// A few steps show it: where a loop was right, the cost is the lower for it at once.
  bool is_lower_with(std::size_t loop) {
    const double cost = cost_;
    terms_.admit(loop);
    return try_solve(kLoose, kFewSteps) && cost_ < cost;
  }

  void from_chordal() {
    keeps_if_lower([&] {
      terms_.hold_again();
      terms_.admit_all();
      if (!chordal_start(terms_.problem(), x_) || !try_solve(kByChance, kFewSteps)) return false;
      terms_.begin(x_);
      for (int solves = 0; solves < gnc_.gnc_options.max_outer_iterations; ++solves) {
        terms_.reweigh(x_);
        const bool arrived = terms_.arrived();
        if (!try_solve(kByChance, kFewSteps)) return false;
        if (arrived) break;
        terms_.advance(gnc_.gnc_options.mu_factor);
      }
      terms_.release();
      terms_.end_graduation();
      return try_settle();
    });
    terms_.release();
    terms_.end_graduation();
    terms_.reweigh(x_);
  }

  /// Tries something from the best so far; goes back to that unless it ends lower.
  template <class Try>
  bool keeps_if_lower(const Try& attempt) {
    const Values before = x_;
    const double cost = cost_;
    if (attempt() && cost_ < cost * kLower) {
      summary().cost = std::min(summary().cost, cost_);
      summary().gradient_norm = max_norm(gradient(graph_, x_).value);
      is_over();  // reports it
      return true;
    }
    x_.assign(before);
    cost_ = cost;
    terms_.reweigh(x_);
    return false;
  }

  /// Whether second chances end here, by the callback or the time limit; the answer is the best so far.
  bool is_over() {
    ++summary().iterations;
    is_over_ = is_over_ || !progress.try_on(summary().gradient_norm);
    return is_over_;
  }

  bool try_settle() {
    for (int solves = 0; solves < kMostSolves; ++solves) {
      const double change = terms_.reweigh(x_), before = cost_;
      if (change == 0) return true;
      if (!try_solve(gnc_.options.cost_tolerance)) return false;
      if (solves > 0 && std::abs(before - cost_) <= gnc_.options.cost_tolerance * before) return true;
    }
    return true;
  }

  /// As solve(), and where it fails nothing ends.
  bool try_solve(double tolerance, int most_iterations = 0) {
    if (is_over()) return false;
    const Summary inner =
        gnc_.solve_inner(terms_.problem(), x_, progress.watch, std::max(tolerance, gnc_.options.cost_tolerance), most_iterations);
    add(inner);
    cost_ = terms_.resolved().cost(graph_, x_);
    return inner.usable();
  }

  void add(const Summary& inner) {
    iterations_ += inner.iterations;
    summary().seconds_setup += inner.seconds_setup;
    summary().seconds_linearize += inner.seconds_linearize;
    summary().seconds_solve += inner.seconds_solve;
  }

  bool ends(const char* rule) {
    progress.end(Termination::converged, rule);
    return true;
  }

  /// The weighted problem, from x_; false where the whole solve ends here.
  bool solve(double tolerance) {
    if (!progress.go_on(summary().gradient_norm)) return false;
    ++summary().iterations;
    const Summary inner = gnc_.solve_inner(terms_.problem(), x_, progress.watch, std::max(tolerance, gnc_.options.cost_tolerance));
    add(inner);
    if (!inner.usable()) {
      progress.end(Termination::failed, inner.rule);
      summary().culprit = inner.culprit;
      summary().cost = summary().cost_first;
      return false;
    }
    cost_ = terms_.resolved().cost(graph_, x_);
    summary().cost = std::min(summary().cost, cost_);
    summary().gradient_norm = max_norm(gradient(graph_, x_).value);
    return true;
  }

  // Never worse than the start.
  void finish(Values& values) {
    summary().iterations = iterations_;
    if (!summary().usable()) return;
    if (cost_ <= summary().cost_first) {
      summary().cost = cost_;
      values.assign(x_);
      return;
    }
    summary().cost = summary().cost_first;
    progress.end(Termination::stopped, "GNC ended at a higher cost than the start, which is kept");
  }

  Gnc& gnc_;
  const Graph& graph_;
  const Values& start_;
  Values x_;
  detail::GraduatedTerms terms_;
  double cost_ = 0;  ///< of the graph itself, at x_
  int iterations_ = 0;
  bool is_over_ = false;
};

Gnc::Gnc(std::unique_ptr<Backend> inner, GncOptions chosen) : gnc_options(std::move(chosen)), inner_(std::move(inner)) {
  if (!inner_) fail<BadOption>("gnc needs a back-end to wrap, and was given none; pass make_backend(\"irls\")");
  gnc_options.validate();
  options = inner_->options;
}

double Gnc::weight(FactorId id) const {
  for (const TermWeight& term : weights_)
    if (term.id.number == id.number && term.id.generation == id.generation) return term.weight;
  fail<BadKey>("factor #", id.number, " has no weight: GNC weighs terms of the graph it solved last whose loss is not convex");
}

Summary Gnc::solve_inner(const Graph& problem, Values& x, const Stopwatch& watch, double tolerance, int most_iterations) {
  constexpr double kLeastTime = 1e-6;  // [s]: a limit must be positive
  inner_->options = options;
  inner_->options.cost_tolerance = tolerance;
  if (most_iterations > 0 && (options.max_iterations == 0 || options.max_iterations > most_iterations))
    inner_->options.max_iterations = most_iterations;
  inner_->options.trace = inner_->options.second_order = inner_->options.findings = false;
  inner_->options.progress = nullptr;
  inner_->options.time_limit = std::max(kLeastTime, options.time_limit - watch.seconds());
  return inner_->solve(problem, x);
}

Summary Gnc::minimize(const Graph& graph, Values& values) {
  gnc_options.validate();
  Options outer = options;
  outer.max_iterations = gnc_options.max_outer_iterations;
  return Run(*this, graph, values, outer).minimize(values);
}

std::unique_ptr<Gnc> gnc(std::unique_ptr<Backend> inner, GncOptions options) {
  return std::make_unique<Gnc>(std::move(inner), std::move(options));
}

}  // namespace holdfast
