// The whole history of a robot, or of many, solved anew at every step in place: an incremental smoother.
//
//   Incremental smoother;
//   smoother.insert(x(0), Pose2());
//   smoother.add(Prior<Pose2>::from_sigmas(Pose2(), {0.1, 0.1, 0.02}), {x(0)});
//   while (…) {
//     smoother.insert(x(k), guess);                                     // new variables with where they begin,
//     const FactorId id = smoother.add(Between<Pose2>{…}, {x(k - 1), x(k)});  // and new factors
//     const IncrementalStep& step = smoother.update();
//     … smoother.at<Pose2>(x(k)) …                                      // the newest estimate
//   }
//   smoother.finish();                                                   // to full accuracy
//
// How. After Kaess et al., iSAM2 (2012): the factorisation of the linearised problem is a tree of cliques. An update makes those again
// whose variables the new factors tie, and those above them up to the root; what hangs below stays. A variable whose estimate has moved
// from where its factors were linearised by more than `relinearize` sigmas is linearised anew there. Variables of the newest factors are
// eliminated last, near the root. When eliminating again has cost `reorder` times a whole factorisation, all is ordered afresh.
// Losses are re-weighted where their factors are linearised anew (iteratively re-weighted least squares).
//
// Accuracy. update() takes Gauss–Newton steps until none of the variables it changed is further than `relinearize` from where it was
// linearised. Where `most_steps` are not enough (Gauss–Newton runs away from a poor start), irls solves the whole graph, whose steps only
// ever lower the cost. finish() goes on until the cost no longer falls.
// Numbers. insert(), add(), remove(), fix() and erase() only note; update() does all of it at once.
// Threads. One thread at a time. Nothing is shared between objects.
#pragma once

#include <holdfast/graph/check.hpp>
#include <holdfast/graph/graph.hpp>
#include <holdfast/solvers/outlier_report.hpp>
#include <holdfast/solvers/summary.hpp>
#include <memory>

namespace holdfast {

namespace io {
class ByteReader;
}  // namespace io

struct IncrementalOptions {
  /// > 0 [sigmas], from where a variable was linearised: √(δᵀHδ), H the sum of its factors' blocks JᵀJ, so all others stand still. The
  /// same in metres and in millimetres, of poses and of points.
  double relinearize = 0.05;
  double propagate = 1e-5;  ///< >= 0 [m, rad, …]: parts of the tree whose neighbours moved by less are not solved again
  int most_steps = 5;       ///< >= 1, of one update
  double reorder = 20;      ///< > 0: work of updates, in whole factorisations, after which all is ordered afresh
  bool findings = false;    ///< IncrementalStep::findings, gone. Cost: three evaluations of the factors of the points that are tied anew
  bool report = false;      ///< IncrementalStep::report. Cost: an evaluation of those factors

  /// Throws BadOption with field, value and rule.
  void validate() const;
};

struct IncrementalStep {
  int steps = 0;         ///< Gauss–Newton steps
  int relinearized = 0;  ///< variables
  int eliminated = 0;    ///< variables eliminated again, of all steps
  bool reordered = false;
  bool settled = true;  ///< no variable is further than `relinearize` from where it was linearised
  bool batch = false;   ///< `most_steps` were not enough: irls solved the whole graph
  double seconds = 0;
  std::vector<Finding> findings;          ///< if asked for: ranges at zero distance and mirror images (check.hpp) that it brought
  std::vector<Finding> gone;              ///< the same: those of before that it ended
  std::vector<MeasurementReport> report;  ///< if asked for: of the factors that came, and of those that were linearised anew
};

/// The graph leaves a direction free: names a variable that it moves. What was added stays; add a prior or a measurement and update again.
class Underdetermined : public Error {
 public:
  using Error::Error;
};

class Incremental {
 public:
  explicit Incremental(IncrementalOptions options = {});
  ~Incremental();
  Incremental(Incremental&&) noexcept;
  Incremental& operator=(Incremental&&) noexcept;

  /// A new variable. Throws BadKey where there is one.
  template <class V>
  void insert(Key key, const V& value) {
    start_.insert(key, value);
    new_keys_.push_back(key);
  }
  /// A new factor. Throws what Graph::add throws, and BadKey and BadType where a key has no variable, or one of another type.
  template <class F>
  FactorId add(const F& factor, const Graph::Keys<F>& keys) {
    return entered(graph_.add(factor, keys));
  }
  template <class F>
  FactorId add(const F& factor, const Graph::Keys<F>& keys, const Loss& loss) {
    return entered(graph_.add(factor, keys, loss));
  }
  FactorId add(const LinearPrior& prior);
  /// A variable of other values, and a factor of another graph, whatever they are. Throw as insert() and add() do.
  void insert_from(const Values& values, Key key);
  FactorId add_from(const Graph& graph, FactorId id) { return entered(graph_.add_from(graph, id)); }
  /// Throws BadKey.
  void remove(FactorId id);
  /// A fixed variable is a constant; before it is updated for the first time. Throws BadKey.
  void fix(Key key);
  /// A variable and all its factors go. Throws BadKey.
  void erase(Key key);
  /// They go, and what is known through them stays as LinearPriors on their neighbours (window/marginalize.hpp). Throws BadKey.
  void marginalize(const std::vector<Key>& keys);

  /// Throws Underdetermined, and BadNumber where a residual or Jacobian is not finite, naming the factor.
  const IncrementalStep& update();
  /// Steps until the cost no longer falls: the batch answer. Where no variable is free, nothing is done.
  Summary finish();

  const Graph& graph() const { return graph_; }
  std::size_t size() const;  ///< variables
  /// The estimate of one variable, or of all (a copy). Throws BadKey, BadType.
  template <class V>
  V at(Key key) const {
    const V& linearized = start_.at<V>(key);
    const double* delta = delta_of(key);
    return delta == nullptr ? linearized : linearized.retract(Eigen::Map<const typename V::Tangent>(delta));
  }
  Values values() const;
  /// The estimate of every variable into values that have them all, and may have more. Throws BadKey.
  void read_into(Values& values) const;
  double cost() const;
  /// Joint covariance of these variables, in their order: of the linearised problem at hand. Throws BadKey (fixed ones, too).
  Eigen::MatrixXd covariance(const std::vector<Key>& keys);

  // ---- a robot that loses power resumes where it was.

  /// Graph, estimates, factorisation, what update() has not seen yet, and a note of yours, in a versioned, checksummed file, written whole
  /// or not at all. Throws BadFile, also where a factor cannot be written (a function).
  void save(const std::string& path, std::string_view note = {}) const;
  /// Takes the place of all there is; the options stay. Returns the note. What follows has the same bits as if nothing had happened, and
  /// FactorIds of before name their factors again. The program has to know the file's variable and factor types (graph/files/binary.hpp).
  /// Cost: a factorisation. Throws BadFile, and is as it was.
  std::string restore(const std::string& path);

 private:
  struct State;
  FactorId entered(FactorId id);
  const double* delta_of(Key key) const;
  void insert_estimate(Key key, Graph& part, Values& estimate) const;
  void enter_variables();
  void enter_factors();
  void linearize(FactorId id, const std::vector<int>* known);
  void solve(bool afresh);
  void relinearize();
  Summary solve_batch(double accuracy);
  std::vector<FactorId> part_of(const std::vector<FactorId>& ids, Graph& part, Values& estimate) const;
  void describe();
  void report_measurements(const std::vector<FactorId>& ids);
  void find_stuck(const std::vector<FactorId>& ids);
  void find_mirrors();
  std::string read_state(io::ByteReader& in);
  void find_factors();

  IncrementalOptions options_;
  Graph graph_;
  Values start_;  ///< where each variable was linearised
  std::vector<Key> new_keys_;
  std::unique_ptr<State> state_;
  IncrementalStep step_;
};

}  // namespace holdfast
