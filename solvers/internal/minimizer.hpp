// What every in-house minimizer does alike: bookkeeping of iterations, limits, callbacks and the stopping rules of Options.
#pragma once

#include <holdfast/graph/resolved.hpp>
#include <holdfast/solvers/backend.hpp>
#include <holdfast/solvers/detail/clock.hpp>

namespace holdfast {

/// Runs alongside one solve; fills its Summary.
class Progress {
 public:
  Progress(const Options& options, int default_max_iterations)
      : options_(options), max_iterations_(options.max_iterations > 0 ? options.max_iterations : default_max_iterations) {}

  Summary summary;
  Stopwatch watch;
  double best_elsewhere = std::numeric_limits<double>::infinity();  ///< the cost where an earlier descent of this solve ended

  /// Of a solve in many processes, which all must end alike: the largest of their numbers. Empty: this process is all.
  std::function<double(double)> largest_of_all;

  /// The start; false where it cannot be solved from.
  bool begin(double cost);
  bool begin(double cost, const Graph& graph, const Resolved& resolved, const Values& values);
  /// After each iteration; false when a limit or the callback ends the solve.
  bool go_on(double gradient_norm);
  /// The same for attempts at a better answer after the end, which have a limit of their own: max_iterations does not count.
  bool try_on(double gradient_norm);
  /// The stopping rules, on the best values so far.
  bool gradient_is_flat(double gradient_norm);
  bool decrease_is_small(double cost_before, double cost);
  double cost_tolerance() const { return options_.cost_tolerance; }
  void end(Termination termination, const char* rule) {
    summary.termination = termination;
    summary.rule = rule;
  }

 private:
  bool report(double gradient_norm);

  const Options& options_;
  int max_iterations_;
};

/// Largest absolute component; NaN if there is one.
double max_norm(const std::vector<double>& v);

}  // namespace holdfast
