// An Incremental that lives through anything: variables and factors that come and go, variables that are marginalised, constants, bad
// input, saves and restores. Beside it, the plain list of what it was told, solved as a batch from scratch: the factors are linear with the
// loss Squared, so a marginalised variable is still there in the batch, and all estimates and covariances agree.
//
// Source: below(n), 0 … n − 1; small(), a number of a few metres; empty(), no more steps. Wrong: called with what is wrong.
#pragma once

#include <algorithm>
#include <holdfast/factors/between.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/solvers/incremental/incremental.hpp>
#include <holdfast/solvers/marginals.hpp>
#include <holdfast/solvers/table.hpp>
#include <map>
#include <set>
#include <sstream>

namespace holdfast::testing {

template <class Source, class Wrong>
class IncrementalLife {
 public:
  IncrementalLife(Source& source, Wrong wrong, std::string path = {})
      : source_(source), wrong_(std::move(wrong)), path_(std::move(path)), smoother_(options()) {}

  void live(int steps) {
    for (int i = 0; i < steps && !source_.empty(); ++i) {
      change();
      if (source_.below(4) == 0) continue;  // two changes in one update
      smoother_.update();
      compare();
    }
    smoother_.update();
    compare();
    const Summary end = smoother_.finish();
    if (!live_.empty() && !fixed_only() && !end.usable()) wrong_(std::string("finish() failed: ") + end.rule);
    compare();
  }
  int compared() const { return compared_; }

 private:
  static constexpr Agent kName{'v'};
  /// Marginalised variables that a chain of factors ties together: what is known through them is one prior on `on`.
  struct Cluster {
    std::set<Key> gone, on;
    std::vector<FactorId> factors;  ///< of the batch
  };
  struct Factor {
    FactorId here, there;  ///< in the smoother, in the batch
    std::vector<Key> keys;
  };

  IncrementalOptions options() {
    IncrementalOptions options;
    options.propagate = 0;
    options.reorder = source_.below(2) == 0 ? 1 : 20;
    options.findings = options.report = source_.below(4) == 0;
    return options;
  }

  void change() {
    const int what = source_.below(16);
    if (live_.size() < 3 || what < 5)
      join();
    else if (what < 8)
      tie(any(), any());
    else if (what < 9)
      prior(any());
    else if (what < 11)
      remove();
    else if (what < 12)
      erase(any());
    else if (what < 14)
      marginalize(any());
    else if (what < 15)
      nonsense();
    else
      save_and_restore();
  }

  Key any() { return live_[static_cast<std::size_t>(source_.below(static_cast<int>(std::min<std::size_t>(live_.size(), 250))))]; }
  Point2 somewhere() {
    const double px = source_.small();
    return Point2(px, source_.small());
  }
  Vector<2> sigmas() {
    const double first = 0.25 * (1 + source_.below(8));
    return Vector<2>(first, 0.25 * (1 + source_.below(8)));
  }

  void join() {
    const Key key = kName(static_cast<unsigned>(next_++));
    const Point2 start = somewhere();
    smoother_.insert(key, start);
    batch_values_.insert(key, start);
    live_.push_back(key);
    if (source_.below(8) == 0) {
      smoother_.fix(key);
      batch_.fix(key);
      fixed_.insert(key);
      return;
    }
    prior(key);
    if (live_.size() > 1) tie(live_[live_.size() - 2], key);
  }
  template <class F, std::size_t n>
  void add(const F& factor, const std::array<Key, n>& keys) {
    const FactorId here = smoother_.add(factor, keys), there = batch_.add(factor, keys);
    factors_.push_back({here, there, {keys.begin(), keys.end()}});
  }
  void prior(Key key) {
    const Point2 at = somewhere();
    add(Prior<Point2>::from_sigmas(at, sigmas()), std::array<Key, 1>{key});
  }
  void tie(Key a, Key b) {
    if (a == b) return;
    const Point2 step = somewhere();
    add(Between<Point2>::from_sigmas(step, sigmas()), std::array<Key, 2>{a, b});
  }
  /// A factor may go where what is left still holds every variable: each keeps a prior.
  void remove() {
    if (factors_.empty()) return;
    const std::size_t i = static_cast<std::size_t>(source_.below(static_cast<int>(std::min<std::size_t>(factors_.size(), 250))));
    if (factors_[i].keys.size() == 1) return;
    smoother_.remove(factors_[i].here);
    batch_.remove(factors_[i].there);
    factors_.erase(factors_.begin() + static_cast<std::ptrdiff_t>(i));
  }
  void forget(Key key) {
    live_.erase(std::find(live_.begin(), live_.end(), key));
    fixed_.erase(key);
  }
  std::vector<Factor> take_factors_on(Key key) {
    std::vector<Factor> taken;
    const auto end = std::stable_partition(factors_.begin(), factors_.end(),
                                           [&](const Factor& f) { return std::find(f.keys.begin(), f.keys.end(), key) == f.keys.end(); });
    taken.assign(end, factors_.end());
    factors_.erase(end, factors_.end());
    return taken;
  }
  std::vector<Cluster> take_clusters_on(Key key) {
    std::vector<Cluster> taken;
    const auto end = std::stable_partition(clusters_.begin(), clusters_.end(), [&](const Cluster& c) { return c.on.count(key) == 0; });
    taken.assign(end, clusters_.end());
    clusters_.erase(end, clusters_.end());
    return taken;
  }
  /// With it goes what was known through marginalised variables: the prior is on it, too.
  void erase(Key key) {
    smoother_.erase(key);
    for (const Factor& factor : take_factors_on(key)) batch_.remove(factor.there);
    for (const Cluster& cluster : take_clusters_on(key)) {
      for (const FactorId id : cluster.factors) batch_.remove(id);
      for (const Key gone : cluster.gone) batch_values_.erase(gone);
    }
    if (fixed_.count(key) == 0) batch_values_.erase(key);  // a constant stays: what is known through it is known
    forget(key);
  }
  void marginalize(Key key) {
    if (fixed_.count(key) != 0) return;
    smoother_.update();  // what is marginalised is linearised where the estimate is
    smoother_.marginalize({key});
    Cluster whole;
    whole.gone.insert(key);
    for (const Factor& factor : take_factors_on(key)) {
      whole.factors.push_back(factor.there);
      for (const Key other : factor.keys)
        if (fixed_.count(other) == 0) whole.on.insert(other);
    }
    for (const Cluster& part : take_clusters_on(key)) {
      whole.gone.insert(part.gone.begin(), part.gone.end());
      whole.on.insert(part.on.begin(), part.on.end());
      whole.factors.insert(whole.factors.end(), part.factors.begin(), part.factors.end());
    }
    whole.on.erase(key);
    clusters_.push_back(whole);
    live_.erase(std::find(live_.begin(), live_.end(), key));
  }
  /// Each is refused, and changes nothing.
  void nonsense() {
    const auto refused = [&](const char* what, auto call) {
      try {
        call();
        wrong_(std::string("taken: ") + what);
      } catch (const Error&) {
      }
    };
    const Key missing = kName(1000000), there = any();
    refused("a variable that is there", [&] { smoother_.insert(there, Point2()); });
    refused("a factor on a missing one", [&] { smoother_.add(Prior<Point2>::from_sigmas(Point2(), Vector<2>(1, 1)), {missing}); });
    refused("no variable erased", [&] { smoother_.erase(missing); });
    refused("no variable marginalised", [&] { smoother_.marginalize({missing}); });
    refused("no factor removed", [&] { smoother_.remove(FactorId{1000000, 0}); });
    refused("a factor of another type", [&] { smoother_.add(Prior<Point3>::from_sigmas(Point3(), Vector<3>(1, 1, 1)), {there}); });
  }
  void save_and_restore() {
    if (path_.empty()) return;
    smoother_.save(path_);
    smoother_ = Incremental(options());
    smoother_.restore(path_);
  }

  bool fixed_only() const { return fixed_.size() == live_.size(); }

  void compare() {
    if (live_.empty() || fixed_only()) return;
    Values answer = batch_values_;
    Options options;
    options.cost_tolerance = 1e-14;
    const Summary summary = make_backend("irls", options)->solve(batch_, answer);
    if (!summary.usable()) {
      wrong_(std::string("the batch failed: ") + summary.rule);
      return;
    }
    for (const Key key : live_) {
      const Vector<2> ours = smoother_.template at<Point2>(key).value, theirs = answer.at<Point2>(key).value;
      if (!((ours - theirs).norm() <= 1e-6 * (1 + theirs.norm()))) {
        std::ostringstream text;
        text << key << " is at " << ours.transpose() << ", in the batch at " << theirs.transpose();
        wrong_(text.str());
        return;
      }
      ++compared_;
    }
    compare_covariances(answer);
  }
  void compare_covariances(const Values& answer) {
    std::vector<Key> pair;
    for (const Key key : live_)
      if (fixed_.count(key) == 0) pair.push_back(key);
    if (pair.size() < 2 || source_.below(8) != 0) return;
    pair = {pair.front(), pair.back()};
    const Eigen::MatrixXd ours = smoother_.covariance(pair),
                          theirs = Marginals(batch_, answer).template joint<Point2, Point2>(pair[0], pair[1]);
    if (!((ours - theirs).norm() <= 1e-8 * theirs.norm())) wrong_("the joint covariance of " + pair[0].str() + " and " + pair[1].str());
  }

  Source& source_;
  Wrong wrong_;
  std::string path_;
  Incremental smoother_;
  Graph batch_;
  Values batch_values_;  ///< of all that were ever there, but for those that were erased
  std::vector<Key> live_;
  std::set<Key> fixed_;
  std::vector<Factor> factors_;
  std::vector<Cluster> clusters_;
  int next_ = 0, compared_ = 0;
};

}  // namespace holdfast::testing
