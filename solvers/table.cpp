#include <holdfast/solvers/gnc.hpp>
#include <holdfast/solvers/incremental/incremental_backend.hpp>
#include <holdfast/solvers/irls/irls.hpp>
#include <holdfast/solvers/nesterov/nesterov.hpp>
#include <holdfast/solvers/table.hpp>
#ifdef HOLDFAST_WITH_CERES
#include <holdfast/solvers/ceres/ceres.hpp>
#endif
#include <map>
#include <mutex>
#include <sstream>
#include <string_view>

namespace holdfast {
namespace {

struct NameTable {
  std::mutex mutex;
  std::map<std::string, BackendFactory> factories;

  NameTable() {
    factories["irls"] = [](const Options& options) { return std::make_unique<Irls>(options); };
    factories["incremental"] = [](const Options& options) { return std::make_unique<IncrementalBackend>(options); };
    factories["nesterov"] = [](const Options& options) { return std::make_unique<Nesterov>(options); };
#ifdef HOLDFAST_WITH_CERES
    for (const CeresVariant& variant : kCeresVariants)
      factories[variant.name] = [variant](const Options& options) { return make_ceres(variant, options); };
#endif
  }
};

/// Before a name: that back-end in GNC (solvers/gnc.hpp).
constexpr std::string_view kGnc = "gnc-";

NameTable& table() {
  static NameTable names;
  return names;
}

}  // namespace

std::unique_ptr<Backend> make_backend(const std::string& name, const Options& options) {
  BackendFactory factory;
  {
    NameTable& names = table();
    const std::lock_guard<std::mutex> lock(names.mutex);
    const auto it = names.factories.find(name);
    if (it != names.factories.end()) factory = it->second;
  }
  if (!factory && name.rfind(kGnc, 0) == 0) return gnc(make_backend(name.substr(kGnc.size()), options));
  if (!factory) {
    std::ostringstream known;
    for (const std::string& one : backend_names()) known << ' ' << one;
    fail<BadOption>("there is no back-end '", name, "' in this build; there are:", known.str(), ", each also as gnc-…");
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

}  // namespace holdfast
