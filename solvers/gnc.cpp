#include <algorithm>
#include <cmath>
#include <holdfast/graph/gradient.hpp>
#include <holdfast/solvers/gnc.hpp>
#include <holdfast/solvers/internal/minimizer.hpp>

namespace holdfast {
namespace {

constexpr double kMostTruncatedMu = 1e9;  // the band between ω = 1 and ω = 0 has closed
constexpr double kFirstWidth = 4.0 / 9;   // the least ω of a widened loss in the first reweighing
constexpr double kMostWidth = 1e18;       // of μ, for a loss that weighs less than this however wide it is

bool is_graduated(const FactorBatch& batch) {
  const Loss& loss = batch.family();
  return !loss.is_convex() && (batch.residual_dim() == 1 || !(loss.per_component || loss.one_sided));
}

double truncated_weight(double u, double mu) {
  if (u <= mu / (mu + 1)) return 1;
  if (u >= (mu + 1) / mu) return 0;
  return std::clamp(std::sqrt(mu * (mu + 1) / u) - mu, 0.0, 1.0);
}

/// Of μ ρ(s/μ), relative to that at 0.
double widened_weight(const Loss& loss, double s, int d, double mu) {
  return std::clamp(loss.rho(s / mu, d).first / loss.rho(0, d).first, 0.0, 1.0);
}

void add_up(const Summary& inner, Summary& summary, int& iterations) {
  iterations += inner.iterations;
  summary.seconds_setup += inner.seconds_setup;
  summary.seconds_linearize += inner.seconds_linearize;
  summary.seconds_solve += inner.seconds_solve;
}

// Never worse than the start.
void finish(double cost, Progress& progress) {
  Summary& summary = progress.summary;
  summary.cost = cost;
  if (cost <= summary.cost_first) return;
  summary.cost = summary.cost_first;
  progress.end(Termination::stopped, "GNC ended at a higher cost than the start, which is kept");
}

}  // namespace

// One solve: the problem with squared terms and weights, and the two μ.
class Gnc::Run {
 public:
  Run(const Graph& original, const Values& values, const std::vector<FactorId>& known_inliers, std::vector<TermWeight>& weights)
      : resolved(original, values), squared(original), weights_(weights) {
    std::vector<std::vector<bool>> known;
    for (const auto& batch : original.batches()) known.emplace_back(batch->size(), false);
    for (FactorId id : known_inliers) known[original.place(id).batch][original.place(id).index] = true;
    weights_.clear();
    for (std::size_t b = 0; b < original.batches().size(); ++b) {
      const FactorBatch& batch = *original.batches()[b];
      if (!is_graduated(batch)) continue;
      for (int i = 0; i < batch.size(); ++i) {
        weights_.push_back({original.id_of(static_cast<int>(b), i), 1.0});
        const Loss& loss = batch.loss(i);
        const double slope = loss.rho(0, batch.residual_dim()).first;
        terms_.push_back({static_cast<int>(b), i, loss, batch.weight(i), slope, known[b][i], false, 0});
      }
      squared.set_loss(static_cast<int>(b), Squared{});
    }
  }

  const Resolved resolved;
  Graph squared;

  bool arrived() const { return truncated_arrived_ && width_ <= 1; }

  /// Both μ from the largest residuals.
  void begin(const Values& values) {
    measure(values);
    double truncated = 0;
    width_ = 1;
    for (const Term& term : terms_) {
      if (term.known) continue;
      if (is_truncated(term))
        truncated = std::max(truncated, term.s / (term.loss.scale * term.loss.scale));
      else
        width_ = std::max(width_, first_width(term));
    }
    truncated_mu_ = truncated > 0.5 ? std::min(1 / (2 * truncated - 1), kMostTruncatedMu) : kMostTruncatedMu;
  }
  void advance(double factor) {
    if (!truncated_arrived_) truncated_mu_ = std::min(truncated_mu_ * factor, kMostTruncatedMu);
    width_ = std::max(1.0, width_ / factor);
  }
  /// ω at these values for the current μ, into the squared problem; returns the largest change.
  double reweigh(const Values& values) {
    measure(values);
    double change = 0;
    truncated_arrived_ = true;
    for (std::size_t t = 0; t < terms_.size(); ++t) {
      const Term& term = terms_[t];
      const double w = term.known           ? 1
                       : is_truncated(term) ? truncated_weight(term.s / (term.loss.scale * term.loss.scale), truncated_mu_)
                                            : widened_weight(term.loss, term.s, rows_of(term), width_);
      if (is_truncated(term) && w > 0 && w < 1 && truncated_mu_ < kMostTruncatedMu) truncated_arrived_ = false;
      change = std::max(change, std::abs(w - weights_[t].weight));
      weights_[t].weight = w;
      squared.set_weight(weights_[t].id, term.weight * w * (term.is_harmless ? 1 : term.slope));
    }
    return change;
  }

 private:
  struct Term {
    int batch, index;
    Loss loss;
    double weight;
    double slope;  ///< ρ'(0): not 1 for StudentT
    bool known;
    bool is_harmless;  ///< on the squared side of a one-sided term
    double s;          ///< ‖r‖², 0 on the squared side
  };
  static bool is_truncated(const Term& term) { return term.loss.kind == Loss::Kind::TruncatedSquares; }

  int rows_of(const Term& term) const { return squared.batches()[term.batch]->residual_dim(); }

  /// The μ at which this term weighs 4/9: 2u for Geman–McClure (Yang et al., remark 5); of other losses the first power of 2 that does.
  double first_width(const Term& term) const {
    if (term.loss.kind == Loss::Kind::GemanMcClure) return 2 * term.s / (term.loss.scale * term.loss.scale);
    double mu = 1;
    while (mu < kMostWidth && widened_weight(term.loss, term.s, rows_of(term), mu) < kFirstWidth) mu *= 2;
    return mu;
  }

  void measure(const Values& values) {
    std::vector<double> r;
    for (Term& term : terms_) {
      const FactorBatch& batch = *squared.batches()[term.batch];
      r.resize(batch.residual_dim());
      batch.evaluate(values, resolved.batches()[term.batch].index.data(), term.index, term.index + 1, r.data(), nullptr);
      double s = 0;
      for (double x : r) s += x * x;
      term.is_harmless = term.loss.one_sided && r[0] > 0;
      term.s = term.is_harmless ? 0 : s;
    }
  }

  std::vector<Term> terms_;
  std::vector<TermWeight>& weights_;
  double truncated_mu_ = 0, width_ = 1;  // μ of truncated squares, and of widened losses
  bool truncated_arrived_ = false;
};

void GncOptions::validate() const {
  if (!(mu_factor > 1 && std::isfinite(mu_factor)))
    fail<BadOption>("mu_factor = ", mu_factor, " must be finite and > 1; the paper's is 1.4");
  if (max_outer_iterations < 1) fail<BadOption>("max_outer_iterations = ", max_outer_iterations, " must be >= 1");
}

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

Summary Gnc::solve_inner(const Graph& squared, Values& x, const Stopwatch& watch) {
  constexpr double kLeastTime = 1e-6;  // [s]: a limit must be positive
  inner_->options = options;
  inner_->options.trace = false;
  inner_->options.progress = nullptr;
  inner_->options.time_limit = std::max(kLeastTime, options.time_limit - watch.seconds());
  return inner_->solve(squared, x);
}

Summary Gnc::minimize(const Graph& graph, Values& values) {
  gnc_options.validate();
  Options outer = options;
  outer.max_iterations = gnc_options.max_outer_iterations;
  Progress progress(outer, outer.max_iterations);
  Summary& summary = progress.summary;
  Run run(graph, values, gnc_options.known_inliers, weights_);
  progress.watch.lap(summary.seconds_setup);
  if (!progress.begin(run.resolved.cost(graph, values), graph, run.resolved, values)) return std::move(summary);

  Values x = values;
  double cost = summary.cost;
  int iterations = 0;
  while (progress.go_on(summary.gradient_norm)) {
    const Summary inner = solve_inner(run.squared, x, progress.watch);
    add_up(inner, summary, iterations);
    if (!inner.usable()) {
      progress.end(Termination::failed, inner.rule);
      summary.culprit = inner.culprit;
      summary.cost = summary.cost_first;
      return std::move(summary);
    }
    const double before = cost;
    cost = run.resolved.cost(graph, x);
    summary.cost = std::min(summary.cost, cost);
    summary.gradient_norm = max_norm(gradient(graph, x).value);
    const bool had_arrived = run.arrived();
    if (summary.iterations++ == 0)
      run.begin(x);
    else
      run.advance(gnc_options.mu_factor);
    const double change = run.reweigh(x);
    if (!run.arrived()) continue;
    if (change == 0) progress.end(Termination::converged, "the weights of GNC no longer change");
    if (had_arrived && std::abs(before - cost) <= options.cost_tolerance * before)
      progress.end(Termination::converged, "the relative change of the cost is within cost_tolerance");
    if (summary.termination == Termination::converged) break;
  }
  summary.iterations = iterations;
  finish(cost, progress);
  if (summary.cost == cost) values.assign(x);
  return std::move(summary);
}

std::unique_ptr<Gnc> gnc(std::unique_ptr<Backend> inner, GncOptions options) {
  return std::make_unique<Gnc>(std::move(inner), std::move(options));
}

}  // namespace holdfast
