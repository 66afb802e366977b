#include <algorithm>
#include <holdfast/solvers/backend.hpp>
#include <holdfast/solvers/detail/clock.hpp>
#include <holdfast/solvers/irls/irls.hpp>
#include <holdfast/solvers/nesterov/nesterov.hpp>
#ifdef HOLDFAST_WITH_CERES
#include <holdfast/solvers/ceres/ceres.hpp>
#endif
#include <map>
#include <mutex>
#include <sstream>

namespace holdfast {
namespace {

struct NameTable {
  std::mutex mutex;
  std::map<std::string, BackendFactory> factories;

  NameTable() {
    factories["irls"] = [](const Options& options) { return std::make_unique<Irls>(options); };
    factories["nesterov"] = [](const Options& options) { return std::make_unique<Nesterov>(options); };
#ifdef HOLDFAST_WITH_CERES
    for (const CeresVariant& variant : kCeresVariants)
      factories[variant.name] = [variant](const Options& options) { return make_ceres(variant, options); };
#endif
  }
};

NameTable& table() {
  static NameTable names;
  return names;
}

}  // namespace

Summary Backend::solve(const Graph& graph, Values& values) {
  const Stopwatch watch;
  options.validate();
  if (graph.size() == 0) fail<BadProblem>("the graph has no factors; add measurements before solving");
  Summary summary = minimize(graph, values);
  summary.seconds = watch.seconds();
  return summary;
}

std::unique_ptr<Backend> make_backend(const std::string& name, const Options& options) {
  BackendFactory factory;
  {
    NameTable& names = table();
    const std::lock_guard<std::mutex> lock(names.mutex);
    const auto it = names.factories.find(name);
    if (it != names.factories.end()) factory = it->second;
  }
  if (!factory) {
    std::ostringstream known;
    for (const std::string& one : backend_names()) known << ' ' << one;
    fail<BadOption>("there is no back-end '", name, "' in this build; there are:", known.str());
  }
  return factory(options);
}

std::vector<std::string> backend_names() {
  NameTable& names = table();
  const std::lock_guard<std::mutex> lock(names.mutex);
  std::vector<std::string> all;
  for (const auto& [name, factory] : names.factories) all.push_back(name);
  return all;
}

void register_backend(const std::string& name, BackendFactory factory) {
  NameTable& names = table();
  const std::lock_guard<std::mutex> lock(names.mutex);
  names.factories[name] = std::move(factory);
}

void Options::validate() const {
  if (max_iterations < 0) fail<BadOption>("max_iterations = ", max_iterations, " must be >= 0 (0: the back-end's own limit)");
  if (!(cost_tolerance >= 0)) fail<BadOption>("cost_tolerance = ", cost_tolerance, " must be >= 0");
  if (!(gradient_tolerance >= 0)) fail<BadOption>("gradient_tolerance = ", gradient_tolerance, " must be >= 0");
  if (threads < 1 || threads > 1024) fail<BadOption>("threads = ", threads, " must be between 1 and 1024");
  if (!(time_limit > 0)) fail<BadOption>("time_limit = ", time_limit, " must be > 0 [s]");
}

const char* to_string(Termination termination) {
  switch (termination) {
    case Termination::converged:
      return "converged";
    case Termination::iteration_limit:
      return "iteration limit";
    case Termination::time_limit:
      return "time limit";
    case Termination::stopped:
      return "stopped";
    case Termination::failed:
      return "failed";
  }
  return "failed";
}

std::string Summary::str() const {
  std::ostringstream text;
  text.precision(9);
  text << to_string(termination) << " (" << why() << "): cost " << cost_first << " -> " << cost << " in " << iterations << " iterations, "
       << seconds << " s";
  return text.str();
}

}  // namespace holdfast
