// Back-ends by their names.
//
//   auto backend = make_backend("irls");              // "ceres", "irls", "nesterov", …: backend_names()
//   Summary s = backend->solve(graph, values);
#pragma once

#include <holdfast/solvers/backend.hpp>
#include <memory>

namespace holdfast {

/// "gnc-irls" is irls in graduated non-convexity (solvers/gnc.hpp), and so with every name. Throws BadOption listing the names there are.
/// What only one back-end has (IrlsOptions) is at its default: construct that back-end to choose it.
std::unique_ptr<Backend> make_backend(const std::string& name, const Options& options = {});
/// Sorted.
std::vector<std::string> backend_names();

/// Enters a back-end under a name (adapters of optional libraries do). A name can be entered again: the last one counts.
using BackendFactory = std::function<std::unique_ptr<Backend>(const Options&)>;
void register_backend(const std::string& name, BackendFactory factory);

}  // namespace holdfast
