#include <algorithm>
#include <holdfast/graph/check.hpp>
#include <holdfast/graph/observability.hpp>
#include <map>
#include <set>
#include <sstream>

namespace holdfast {
namespace {

using Kind = Finding::Kind;
using Severity = Finding::Severity;

class Doctor {
 public:
  Doctor(const Graph& graph, const Values& values) : graph_(graph), values_(values) {}

  std::vector<Finding> examine() {
    if (graph_.size() == 0) add(Kind::empty_graph, Severity::error, "the graph has no factors; add measurements", {});
    const bool keys_are_good = check_keys();
    const bool numbers_are_good = check_values();
    check_untouched();
    if (graph_.size() == 0 || !keys_are_good) return std::move(findings_);
    const Resolved resolved(graph_, values_);
    if (resolved.tangent_dim() == 0)
      add(Kind::nothing_free, Severity::error, "every variable that a factor touches is fixed; unfix what is to be estimated", {});
    const bool residuals_are_good = numbers_are_good && check_residuals(resolved);
    if (residuals_are_good && resolved.tangent_dim() > 0) check_observability(resolved);
    return std::move(findings_);
  }

 private:
  static constexpr double kMostInSquare = 1e100;  // leaves its square room for weights

  template <class... Parts>
  void add_text(Kind kind, Severity severity, std::vector<Key> keys, const Parts&... parts) {
    std::ostringstream text;
    (text << ... << parts);
    add(kind, severity, text.str(), std::move(keys));
  }
  void add(Kind kind, Severity severity, std::string text, std::vector<Key> keys) {
    findings_.push_back({kind, severity, std::move(text), std::move(keys)});
  }

  bool check_keys() {
    const std::size_t before = findings_.size();
    std::set<Key> unknown;
    for (const auto& batch : graph_.batches())
      for (int i = 0; i < batch->size(); ++i)
        for (int k = 0; k < batch->arity(); ++k) check_key(*batch, i, k, unknown);
    return findings_.size() == before;
  }
  void check_key(const FactorBatch& batch, int i, int k, std::set<Key>& unknown) {
    const Key key = batch.keys(i)[k];
    if (!values_.contains(key)) {
      if (unknown.insert(key).second)
        add_text(Kind::unknown_key, Severity::error, {key}, batch.describe(i), ": key ", key, " has no value; insert a ",
                 batch.type_names()[k], " for it");
      return;
    }
    const PoolBase& pool = values_.pool(values_.slot(key).pool);
    if (pool.type() != batch.types()[k])
      add_text(Kind::wrong_type, Severity::error, {key}, batch.describe(i), ": key ", key, " is a ", pool.type_name(),
               ", the factor needs a ", batch.type_names()[k]);
  }

  bool check_values() {
    bool good = true;
    for (const auto& pool : values_.pools())
      for (int i = 0; i < pool->size(); ++i) {
        const Key key = pool->keys()[i];
        if (!pool->is_finite(i))
          add_text(Kind::bad_value, Severity::error, {key}, key, " (", pool->type_name(), ") is not finite; give it a finite start");
        else if (const double most = largest(*pool, i); most > kMostInSquare)
          add_text(Kind::bad_value, Severity::error, {key}, key, " (", pool->type_name(), ") holds ", most, ", above ", kMostInSquare,
                   "; the squares of such numbers overflow: check its unit, its start, and the measurements it came from");
        else
          continue;
        good = false;
      }
    return good;
  }
  static double largest(const PoolBase& pool, int i) {
    return Eigen::Map<const Eigen::VectorXd>(pool.data(i), pool.ambient()).cwiseAbs().maxCoeff();
  }

  void check_untouched() {
    std::set<Key> touched;
    for (const auto& batch : graph_.batches())
      touched.insert(batch->keys(0), batch->keys(0) + static_cast<std::ptrdiff_t>(batch->size()) * batch->arity());
    for (Key key : values_.keys())
      if (touched.count(key) == 0)
        add_text(Kind::unconstrained_variable, Severity::warning, {key}, key, ": no factor touches it; it will stay as it is");
  }

  bool check_residuals(const Resolved& resolved) {
    const Resolved::Culprit culprit = resolved.first_non_finite(graph_, values_);
    if (culprit.text.empty()) return true;
    add(Kind::bad_residual, Severity::error, culprit.text + "; check its measurement and its start", culprit.keys);
    return false;
  }

  static std::string agents_of(const GraphComponent& component, const Resolved& resolved) {
    constexpr std::size_t kMostNamed = 8;
    std::map<Agent, std::pair<int, Key>> agents;
    for (int v : component.variables) {
      const Key key = resolved.variables()[v].key;
      const auto it = agents.try_emplace(key.agent(), 0, key).first;
      ++it->second.first;
      it->second.second = std::min(it->second.second, key);
    }
    std::ostringstream text;
    std::size_t named = 0;
    for (const auto& [agent, count] : agents) {
      if (++named > kMostNamed) break;
      text << (named > 1 ? ", " : "") << count.first << " of agent " << agent << " from " << count.second;
    }
    if (agents.size() > kMostNamed) text << ", and those of " << agents.size() - kMostNamed << " more agents";
    return text.str();
  }

  void check_observability(const Resolved& resolved) {
    const std::vector<GraphComponent> components = observability(graph_, resolved, values_);
    for (const GraphComponent& component : components) {
      const Key first = resolved.variables()[component.variables.front()].key;
      const std::string who = std::to_string(component.variables.size()) + " variables (" + agents_of(component, resolved) + ")";
      if (components.size() > 1)
        add_text(Kind::disconnected, Severity::warning, {first}, who, " share no factor with the other ", components.size() - 1,
                 " parts of the graph; they are solved side by side");
      report_gauge(component, who, first);
      report_directions(component);
    }
  }
  void report_gauge(const GraphComponent& component, const std::string& who, Key first) {
    if (component.gauge.empty()) return;
    std::ostringstream motions;
    for (const std::string& motion : component.gauge) motions << (motions.tellp() > 0 ? ", " : "") << motion;
    add_text(Kind::free_gauge, Severity::error, {first}, who, " can move together at no cost (", motions.str(), "); add a prior on ", first,
             " or fix it");
  }
  /// "heading" where the variable is a pose in the plane.
  std::string name_of(const GraphComponent::Direction& d) const {
    const PoolBase& pool = values_.pool(values_.slot(d.key).pool);
    const std::string type = pool.type_name(), axis = d.component < 6 ? std::string(1, "xyzxyz"[d.component]) : "";
    if (type == "Point2" || type == "Point3") return "position " + axis;
    if (type == "Pose2" && d.component == 2) return "heading";
    if (type == "Pose3" && d.component >= 3) return "rotation " + axis;
    return "tangent direction " + std::to_string(d.component);
  }
  void report_directions(const GraphComponent& component) {
    for (const GraphComponent::Direction& d : component.directions)
      add_text(Kind::unconstrained_direction, d.only_here ? Severity::warning : Severity::error, {d.key}, d.key, ": ", name_of(d),
               " is not constrained by any factor", d.others > 0 ? " (" + std::to_string(d.others) + " more variables move with it)" : "",
               d.only_here ? " at these values, where a one-sided factor on it is at rest" : "; add a measurement or a prior");
    if (component.more_directions > 0)
      add_text(Kind::unconstrained_direction, Severity::error, {}, component.more_directions,
               " or more further directions are not constrained");
  }

  const Graph& graph_;
  const Values& values_;
  std::vector<Finding> findings_;
};

}  // namespace

std::vector<Finding> check(const Graph& graph, const Values& values) { return Doctor(graph, values).examine(); }

bool has_errors(const std::vector<Finding>& findings) {
  return std::any_of(findings.begin(), findings.end(), [](const Finding& f) { return f.severity == Severity::error; });
}

const char* to_string(Finding::Kind kind) {
  static const char* const names[] = {"empty graph",
                                      "unknown key",
                                      "wrong type",
                                      "bad value",
                                      "bad residual",
                                      "nothing free",
                                      "unconstrained variable",
                                      "unconstrained direction",
                                      "disconnected",
                                      "free gauge",
                                      "fixed is unknown",
                                      "bad time",
                                      "repaired noise",
                                      "no noise",
                                      "noise of iSAM"};
  return names[static_cast<int>(kind)];
}

}  // namespace holdfast
