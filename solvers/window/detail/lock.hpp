// What a Window keeps of an agent that keeps lock (solvers/window/lock.hpp). No API.
#pragma once

#include <functional>
#include <holdfast/solvers/window/lock.hpp>
#include <holdfast/solvers/window/marginalize.hpp>

namespace holdfast::detail {

struct Lock {
  /// Adds what is known of a state of which nothing is known but where it is seen: a factor on it, about its value.
  using NothingKnown = std::function<FactorId(Graph& graph, const Values& values, Key state)>;
  /// A measurement of the agent, and its copy in the memory (number −1: not remembered).
  struct Measured {
    Key state;
    FactorId id, copy;
  };
  struct Left {
    Key key;
    double time;
  };

  Lock(const LockOptions& chosen, NothingKnown said) : options(chosen), nothing_known(std::move(said)) { options.validate(); }

  bool is_settled() const { return states > options.settled; }
  /// A state leaves the window, its last estimate still in `from`; `held`: states that stay.
  void leave(Key key, double time, const Values& from, std::size_t held);
  /// Without this measurement, from now on.
  void forget(FactorId id);
  /// Without all that is measured on this variable.
  void forget(Key landmark);

  LockOptions options;
  NothingKnown nothing_known;
  Graph memory;                    ///< the measurements of the states in memory, and nothing else
  Values values;                   ///< of the states in memory that have left the window
  std::vector<Left> left;          ///< these, oldest first
  std::vector<Measured> measured;  ///< as they came
  std::size_t fresh = 0;           ///< measurements before this one have been seen by a step
  int states = 0;                  ///< that there ever were
  int next_acquisition = 0;        ///< not before so many states
  bool is_new = true;              ///< nothing is said of its first state yet
  bool is_unplaced = false;        ///< its first state is yet to be put where it is seen
  FactorId prior;                  ///< what nothing_known said, where it is in the window's graph
  Marginalizer marginalizer;
};

/// ‖r‖ of a factor [sigmas].
double residual_norm(const Graph& graph, const Values& values, FactorId id);
/// Moves one variable of a factor to where the factor has no residual, or as little as that variable can do, by the shortest way:
/// Gauss–Newton steps of least length.
void move_to_measurement(const Graph& graph, Values& values, FactorId id, Key key);
/// Puts a variable of one Values into another, new or in the place of the old one.
void copy_variable(Key key, const Values& from, Values& to);

}  // namespace holdfast::detail
