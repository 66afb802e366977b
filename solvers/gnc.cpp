#include <algorithm>
#include <cmath>
#include <holdfast/graph/gradient.hpp>
#include <holdfast/solvers/gnc.hpp>
#include <holdfast/solvers/internal/minimizer.hpp>

namespace holdfast {
namespace {

constexpr double kMostTruncatedMu = 1e9;  // the band between ω = 1 and ω = 0 has closed

bool is_graduated(const FactorBatch& batch) {
  const Loss& loss = batch.loss();
  const bool kind = loss.kind == Loss::Kind::TruncatedSquares || loss.kind == Loss::Kind::GemanMcClure;
  return kind && (batch.residual_dim() == 1 || !(loss.per_component || loss.one_sided));
}

double truncated_weight(double u, double mu) {
  if (u <= mu / (mu + 1)) return 1;
  if (u >= (mu + 1) / mu) return 0;
  return std::clamp(std::sqrt(mu * (mu + 1) / u) - mu, 0.0, 1.0);
}

double geman_mcclure_weight(double u, double mu) {
  const double root = mu / (u + mu);
  return root * root;
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
        terms_.push_back({static_cast<int>(b), i, batch.loss(), batch.weight(i), known[b][i], 0});
      }
      squared.set_loss(static_cast<int>(b), Squared{});
    }
  }

  const Resolved resolved;
  Graph squared;

  bool arrived() const { return truncated_arrived_ && geman_mcclure_mu_ <= 1; }

  /// μ from the largest u.
  void begin(const Values& values) {
    measure(values);
    double truncated = 0, geman_mcclure = 0;
    for (const Term& term : terms_)
      if (!term.known) {
        double& largest = is_truncated(term) ? truncated : geman_mcclure;
        largest = std::max(largest, term.u);
      }
    truncated_mu_ = truncated > 0.5 ? std::min(1 / (2 * truncated - 1), kMostTruncatedMu) : kMostTruncatedMu;
    geman_mcclure_mu_ = std::max(1.0, 2 * geman_mcclure);
  }
  void advance(double factor) {
    if (!truncated_arrived_) truncated_mu_ = std::min(truncated_mu_ * factor, kMostTruncatedMu);
    geman_mcclure_mu_ = std::max(1.0, geman_mcclure_mu_ / factor);
  }
  /// ω at these values for the current μ, into the squared problem; returns the largest change.
  double reweigh(const Values& values) {
    measure(values);
    double change = 0;
    truncated_arrived_ = true;
    for (std::size_t t = 0; t < terms_.size(); ++t) {
      const Term& term = terms_[t];
      const double w = term.known           ? 1
                       : is_truncated(term) ? truncated_weight(term.u, truncated_mu_)
                                            : geman_mcclure_weight(term.u, geman_mcclure_mu_);
      if (is_truncated(term) && w > 0 && w < 1 && truncated_mu_ < kMostTruncatedMu) truncated_arrived_ = false;
      change = std::max(change, std::abs(w - weights_[t].weight));
      weights_[t].weight = w;
      squared.set_weight(weights_[t].id, term.weight * w);
    }
    return change;
  }

 private:
  struct Term {
    int batch, index;
    Loss loss;
    double weight;
    bool known;
    double u;
  };
  static bool is_truncated(const Term& term) { return term.loss.kind == Loss::Kind::TruncatedSquares; }

  void measure(const Values& values) {
    std::vector<double> r;
    for (Term& term : terms_) {
      const FactorBatch& batch = *squared.batches()[term.batch];
      r.resize(batch.residual_dim());
      batch.evaluate(values, resolved.batches()[term.batch].index.data(), term.index, term.index + 1, r.data(), nullptr);
      double s = 0;
      for (double x : r) s += x * x;
      term.u = term.loss.one_sided && r[0] > 0 ? 0 : s / (term.loss.scale * term.loss.scale);
    }
  }

  std::vector<Term> terms_;
  std::vector<TermWeight>& weights_;
  double truncated_mu_ = 0, geman_mcclure_mu_ = 1;
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
  fail<BadKey>("factor #", id.number, " has no weight: GNC weighs TruncatedSquares and GemanMcClure terms of the graph it solved last");
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
