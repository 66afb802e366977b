#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <holdfast/graph/variables.hpp>
#include <holdfast/solvers/internal/agreeing_loops.hpp>
#include <holdfast/solvers/internal/graduated_terms.hpp>
#include <holdfast/solvers/marginals.hpp>
#include <limits>

namespace holdfast::detail {
namespace {

constexpr double kMostTruncatedMu = 1e9;  // the band between ω = 1 and ω = 0 has closed
constexpr double kFirstWidth = 4.0 / 9;   // the least ω of a widened loss in the first reweighing
constexpr double kMostWidth = 1e18;       // of μ, for a loss that weighs less than this however wide it is
constexpr double kFits = 2;               // [sigmas] root mean square
constexpr int kAgreeing = 2;              // other loops that a loop should agree with
constexpr int kFewest = 3;                // agreeing loops that say something
constexpr double kFewTerms = 0.05;        // of all terms: so many of weight 0 may stay in the problem
constexpr double kNotFar = 2;             // times the threshold

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

}  // namespace

GraduatedTerms::GraduatedTerms(const Graph& original, const Values& values, const std::vector<FactorId>& known_inliers,
                               std::vector<Gnc::TermWeight>& weights)
    : resolved_(original, values), squared_(original), weights_(weights) {
  std::vector<std::vector<bool>> known;
  for (const auto& batch : original.batches()) known.emplace_back(batch->size(), false);
  for (FactorId id : known_inliers) known[original.place(id).batch][original.place(id).index] = true;
  weights_.clear();
  for (std::size_t b = 0; b < original.batches().size(); ++b) {
    const FactorBatch& batch = *original.batches()[b];
    all_linear_ = all_linear_ && (batch.is_linear() || batch.size() == 0);
    if (!is_graduated(batch)) continue;
    const bool is_loop =
        dynamic_cast<const RelativePoses<Pose2>*>(&batch) != nullptr || dynamic_cast<const RelativePoses<Pose3>*>(&batch) != nullptr;
    for (int i = 0; i < batch.size(); ++i) {
      weights_.push_back({original.id_of(static_cast<int>(b), i), 1.0});
      const Loss& loss = batch.loss(i);
      const double slope = loss.rho(0, batch.residual_dim()).first;
      terms_.push_back({static_cast<int>(b), i, loss, batch.weight(i), slope, known[b][i]});
      terms_.back().is_loop = is_loop;
      any_truncated_ = any_truncated_ || is_truncated(terms_.back());
    }
    squared_.set_loss(static_cast<int>(b), Squared{});
  }
  is_left_out_.assign(terms_.size(), false);
}

bool GraduatedTerms::fit_the_rest(const Graph& original, const Values& values) {
  double cost = 0;
  int rows = 0;
  for (std::size_t b = 0; b < original.batches().size(); ++b) {
    const FactorBatch& batch = *original.batches()[b];
    if (is_graduated(batch) || batch.size() == 0) continue;
    cost += batch.cost(values, resolved_.batches()[b].index.data(), 0, batch.size());
    rows += batch.size() * batch.residual_dim();
  }
  return rows > 0 && cost <= 0.5 * kFits * kFits * rows;
}

bool GraduatedTerms::hold_back_lone_loops(const Graph& original) {
  std::vector<FactorId> candidates;
  std::vector<std::size_t> term;
  for (std::size_t t = 0; t < terms_.size(); ++t)
    if (!terms_[t].known) {
      candidates.push_back(weights_[t].id);
      term.push_back(t);
    }
  const std::vector<int> agreeing = agreements(original, candidates);
  const auto with = [&](int least) { return std::count_if(agreeing.begin(), agreeing.end(), [=](int n) { return n >= least; }); };
  const auto some = with(1), enough = with(kAgreeing);
  if (some < kFewest) return false;
  const int least = enough >= kFewest && 3 * enough >= some ? kAgreeing : 1;
  for (std::size_t c = 0; c < candidates.size(); ++c) terms_[term[c]].was_held = terms_[term[c]].is_held = agreeing[c] < least;
  return true;
}

void GraduatedTerms::release() {
  for (Term& term : terms_) term.is_held = false;
}

void GraduatedTerms::hold_again() {
  for (Term& term : terms_) term.is_held = term.was_held;
}

void GraduatedTerms::admit_all() {
  for (std::size_t t = 0; t < terms_.size(); ++t) set_weight(t, terms_[t].is_held ? 0 : 1);
}

std::vector<std::size_t> GraduatedTerms::doubtful_loops(const Values& values) {
  constexpr double kRejected = 0.1;      // ω
  constexpr double kManyOfThem = 0.04;   // rejected: something went wrong
  constexpr std::size_t kFewLoops = 32;  // that each can be tried
  measure(values);
  std::vector<std::size_t> loops, all;
  std::size_t came_first = 0, of_all = 0;
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    const Term& term = terms_[t];
    if (!term.is_loop || term.known || !(term.weight > 0)) continue;
    ++of_all;
    came_first += !term.was_held;
    if (!(weights_[t].weight < kRejected)) continue;
    all.push_back(t);
    if (!term.was_held) loops.push_back(t);
  }
  const auto many = [](std::size_t some, std::size_t of) { return static_cast<double>(some) >= kManyOfThem * static_cast<double>(of); };
  if (all.size() <= kFewLoops && many(all.size(), of_all))
    loops = std::move(all);
  else if (!many(loops.size(), came_first))
    loops.clear();
  std::stable_sort(loops.begin(), loops.end(), [&](std::size_t a, std::size_t b) { return terms_[a].s < terms_[b].s; });
  return loops;
}

void GraduatedTerms::begin(const Values& values) {
  measure(values);
  double truncated = 0;
  width_ = 1;
  for (const Term& term : terms_) {
    if (term.known || term.is_held) continue;
    if (is_truncated(term))
      truncated = std::max(truncated, term.s / (term.loss.scale * term.loss.scale));
    else
      width_ = std::max(width_, first_width(term));
  }
  truncated_mu_ = truncated > 0.5 ? std::min(1 / (2 * truncated - 1), kMostTruncatedMu) : kMostTruncatedMu;
}

void GraduatedTerms::advance(double factor) {
  if (!truncated_arrived_) truncated_mu_ = std::min(truncated_mu_ * factor, kMostTruncatedMu);
  width_ = std::max(1.0, width_ / factor);
}

void GraduatedTerms::end_graduation() {
  truncated_mu_ = kMostTruncatedMu;
  width_ = 1;
}

double GraduatedTerms::reweigh(const Values& values) {
  measure(values);
  double change = 0;
  truncated_arrived_ = true;
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    const Term& term = terms_[t];
    const double w = term.known           ? 1
                     : term.is_held       ? 0
                     : is_truncated(term) ? truncated_weight(term.s / (term.loss.scale * term.loss.scale), truncated_mu_)
                                          : widened_weight(term.loss, term.s, rows_of(term), width_);
    if (is_truncated(term) && w > 0 && w < 1 && truncated_mu_ < kMostTruncatedMu) truncated_arrived_ = false;
    change = std::max(change, std::abs(w - weights_[t].weight));
    set_weight(t, w);
  }
  return change;
}

void GraduatedTerms::set_weight(std::size_t t, double weight) {
  const Term& term = terms_[t];
  weights_[t].weight = weight;
  const double w = term.weight * weight * (term.is_harmless ? 1 : term.slope);
  squared_.set_weight(weights_[t].id, w);
  if (left_out_ > 0 && !is_left_out_[t]) reduced_.set_weight(weights_[t].id, w);
}

// Random loops that are rejected would make the factorisation dense. A problem of another structure costs its symbolic phase anew, so a
// few may stay, and those that are not far off, which may well come back.
const Graph& GraduatedTerms::problem() {
  const auto may_leave = [&](std::size_t t) { return weights_[t].weight == 0 && !is_near(terms_[t]); };
  std::size_t zeros = 0;
  bool one_is_missing = false;
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    zeros += may_leave(t);
    one_is_missing = one_is_missing || (is_left_out_[t] && weights_[t].weight > 0);
  }
  const auto few = static_cast<std::size_t>(kFewTerms * static_cast<double>(terms_.size()));
  if (!one_is_missing && zeros <= left_out_ + few) return left_out_ > 0 ? reduced_ : squared_;
  reduced_ = squared_;
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    is_left_out_[t] = may_leave(t);
    if (is_left_out_[t]) reduced_.remove(weights_[t].id);
  }
  left_out_ = zeros;
  return left_out_ > 0 ? reduced_ : squared_;
}

std::vector<std::size_t> GraduatedTerms::compatible_rejects(const Values& values) {
  std::vector<std::size_t> near, compatible;
  for (std::size_t t = 0; t < terms_.size(); ++t)
    if (weights_[t].weight == 0 && is_near(terms_[t])) near.push_back(t);
  if (near.empty()) return near;
  const Marginals marginals(problem(), values);
  for (const std::size_t t : near)
    if (is_compatible(terms_[t], values, marginals)) compatible.push_back(t);
  return compatible;
}

bool GraduatedTerms::is_compatible(const Term& term, const Values& values, const Marginals& marginals) const {
  return misfit(term, values, marginals) <= term.loss.scale * term.loss.scale;
}

double GraduatedTerms::misfit(const Term& term, const Values& values, const Marginals& marginals) const {
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  const FactorBatch& batch = *squared_.batches()[term.batch];
  if (batch.arity() > 2) return kUnknown;  // no joint covariance of more than two
  const int m = batch.residual_dim(), n = batch.total_dim();
  Eigen::VectorXd r(m);
  Eigen::MatrixXd J(m, n);
  batch.evaluate(values, resolved_.batches()[term.batch].index.data(), term.index, term.index + 1, r.data(), J.data());
  const Key* const keys = batch.keys(term.index);
  try {
    const std::vector<double> P = batch.arity() == 1 ? marginals.covariance(keys[0]) : marginals.joint(keys[0], keys[1]);
    const Eigen::MatrixXd S = Eigen::MatrixXd::Identity(m, m) + J * Eigen::Map<const Eigen::MatrixXd>(P.data(), n, n) * J.transpose();
    return r.dot(S.llt().solve(r));
  } catch (const UnobservableError&) {  // only this term would tie the variable: nothing contradicts it, and nothing speaks for it
    return kUnknown;
  } catch (const BadKey&) {
    return kUnknown;
  }
}

std::vector<std::size_t> GraduatedTerms::affordable(const std::vector<std::size_t>& loops, const Values& values) {
  if (loops.empty()) return loops;
  double gain = 0;
  for (const Term& term : terms_)
    if (!term.known) gain += term.weight * term.loss.rho(term.s, rows_of(term)).value;
  const Marginals marginals(problem(), values);
  std::vector<std::pair<double, std::size_t>> priced;
  for (const std::size_t t : loops) {
    const double price = terms_[t].weight * misfit(terms_[t], values, marginals);
    if (price < gain) priced.emplace_back(price, t);
  }
  std::stable_sort(priced.begin(), priced.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::size_t> cheapest_first;
  for (const auto& [price, t] : priced) cheapest_first.push_back(t);
  return cheapest_first;
}

bool GraduatedTerms::is_near(const Term& term) { return is_truncated(term) && term.s < std::pow(kNotFar * term.loss.scale, 2); }

// The μ at which this term weighs 4/9: 2u for Geman–McClure (Yang et al., remark 5); of other losses the first power of 2 that does.
double GraduatedTerms::first_width(const Term& term) const {
  if (term.loss.kind == Loss::Kind::GemanMcClure) return 2 * term.s / (term.loss.scale * term.loss.scale);
  double mu = 1;
  while (mu < kMostWidth && widened_weight(term.loss, term.s, rows_of(term), mu) < kFirstWidth) mu *= 2;
  return mu;
}

void GraduatedTerms::measure(const Values& values) {
  std::vector<double> r;
  for (Term& term : terms_) {
    const FactorBatch& batch = *squared_.batches()[term.batch];
    r.resize(batch.residual_dim());
    batch.evaluate(values, resolved_.batches()[term.batch].index.data(), term.index, term.index + 1, r.data(), nullptr);
    double s = 0;
    for (double x : r) s += x * x;
    term.is_harmless = term.loss.one_sided && r[0] > 0;
    term.s = term.is_harmless ? 0 : s;
  }
}

}  // namespace holdfast::detail
