// The one interface of all back-ends, and their name table.
//
//   auto backend = make_backend("irls");              // "ceres", "irls", "nesterov", …: backend_names()
//   Summary s = backend->solve(graph, values);        // values: start in, answer out; unchanged when the solve fails
#pragma once

#include <holdfast/graph/graph.hpp>
#include <holdfast/solvers/summary.hpp>
#include <memory>

namespace holdfast {

class Backend {
 public:
  explicit Backend(Options chosen = {}) : options(std::move(chosen)) {}
  virtual ~Backend() = default;
  virtual std::string name() const = 0;

  /// Minimises graph.cost from `values`. Throws BadOption (options), BadProblem (no factor, nothing free), BadKey, BadType; a
  /// residual that is not finite ends in Termination::failed naming the factor. Whatever fails leaves values as they were.
  Summary solve(const Graph& graph, Values& values);

  Options options;

 protected:
  /// `values` is a scratch copy on entry to a failing solve: the caller keeps its own.
  virtual Summary minimize(const Graph& graph, Values& values) = 0;
};

/// A problem that cannot be posed to a solver: no factors, or no free variable.
class BadProblem : public Error {
 public:
  using Error::Error;
};

/// Throws BadOption listing the names there are.
std::unique_ptr<Backend> make_backend(const std::string& name, const Options& options = {});
std::vector<std::string> backend_names();

/// Enters a back-end under a name (adapters of optional libraries do). A name can be entered again: the last one counts.
using BackendFactory = std::function<std::unique_ptr<Backend>(const Options&)>;
void register_backend(const std::string& name, BackendFactory factory);

}  // namespace holdfast
