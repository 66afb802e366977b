// The one interface of all back-ends. solvers/table.hpp makes one by its name.
//
//   Summary s = backend->solve(graph, values);        // values: start in, answer out; unchanged when the solve fails
//
// Whatever the back-end: with Options::second_order an end at a saddle is left and solved on from (second_order.hpp), and with
// Options::findings the summary holds what check() finds at the answer.
//
// Threads. A back-end keeps its memory for the next solve: one thread at a time may use it, and different threads different back-ends, even
// on the same graph. register_backend() is called before threads start.
#pragma once

#include <holdfast/graph/graph.hpp>
#include <holdfast/solvers/summary.hpp>

namespace holdfast {

namespace detail {
class NewtonSystem;
}

class Backend {
 public:
  explicit Backend(Options chosen = {}) : options(std::move(chosen)) {}
  virtual ~Backend() = default;
  virtual std::string name() const = 0;

  /// Minimises graph.cost from `values`. Throws BadOption (options), BadProblem (no factor, nothing free), BadKey, BadType; a
  /// residual that is not finite ends in Termination::failed naming the factor.
  /// Whatever fails or throws leaves values as they were, bit for bit, whatever minimize() did. Until it returns, `values` holds the
  /// start, also for the progress callback. References into `values` stay valid.
  Summary solve(const Graph& graph, Values& values);

  /// The back-end that goes on from a place near the answer: itself, or the one it wraps where it would begin afresh (GNC).
  virtual Backend& near_answer() { return *this; }
  /// What the last solve of this structure linearised and factored near its answer; null where the back-end keeps no such thing.
  /// Internal: second_order.hpp need not do it again.
  virtual detail::NewtonSystem* last_system(const Graph&, const Values&) { return nullptr; }

  Options options;

 protected:
  /// What a back-end implements. `values` is a copy of the caller's: the start on entry, the answer on exit. It may be left in any state
  /// where the summary is not usable() or an exception leaves; it keeps its keys (a solve that adds or erases some has failed).
  virtual Summary minimize(const Graph& graph, Values& values) = 0;

 private:
  void look_further(const Graph& graph, Values& values, Summary& summary);

  Values scratch_;  ///< kept from solve to solve, so that a structure met before allocates nothing
};

/// True where every factor and every loss is convex, as they say of themselves: the graph has one minimum, or a convex set of equal ones.
bool is_convex_problem(const Graph& graph);

/// A problem that cannot be posed to a solver: no factors, or no free variable.
class BadProblem : public Error {
 public:
  using Error::Error;
};

}  // namespace holdfast
