#include <algorithm>
#include <holdfast/graph/check.hpp>
#include <holdfast/graph/mirror.hpp>
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
    if (residuals_are_good && resolved.tangent_dim() > 0) {
      if (Finding stuck = zero_distance(graph_, values_); !stuck.keys.empty()) findings_.push_back(std::move(stuck));
      check_observability(resolved);
      const std::vector<Finding> mirrors = mirror_findings(graph_, values_);
      findings_.insert(findings_.end(), mirrors.begin(), mirrors.end());
    }
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
  /// "heading", "velocity x", …: the entry of the tangent in the field's words where the variable is one of ours.
  std::string name_of(const GraphComponent::Direction& d) const {
    static const std::map<std::string, std::pair<std::vector<std::string>, bool>> known{
        // by axis (true): what is interleaved axis by axis; else the entries themselves
        {"Point2", {{"position"}, true}},
        {"Point3", {{"position"}, true}},
        {"Motion2", {{"position", "velocity"}, true}},
        {"Motion3", {{"position", "velocity"}, true}},
        {"Accel2", {{"position", "velocity", "acceleration"}, true}},
        {"Accel3", {{"position", "velocity", "acceleration"}, true}},
        {"Pose2", {{"position x", "position y", "heading"}, false}},
        {"Pose3", {{"position x", "position y", "position z", "rotation x", "rotation y", "rotation z"}, false}},
        {"Turning2", {{"position x", "velocity x", "position y", "velocity y", "turn rate"}, false}},
    };
    const auto it = known.find(values_.pool(values_.slot(d.key).pool).type_name());
    if (it == known.end()) return "tangent direction " + std::to_string(d.component);
    const auto& [names, by_axis] = it->second;
    const int n = static_cast<int>(names.size());
    return by_axis ? names[d.component % n] + ' ' + "xyz"[d.component / n] : names[d.component];
  }
  void report_directions(const GraphComponent& component) {
    for (const GraphComponent::Direction& d : component.directions)
      add_text(Kind::unconstrained_direction, d.only_here ? Severity::warning : Severity::error, {d.key}, d.key, ": ", name_of(d),
               " is not constrained by any factor", d.others > 0 ? " (" + std::to_string(d.others) + " more variables move with it)" : "",
               d.only_here ? " at these values, where a factor on it has no derivative (a one-sided one at rest, a range at zero distance)"
                           : "; add a measurement or a prior");
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

std::vector<Finding> mirror_findings(const Graph& graph, const Values& values) {
  static constexpr std::size_t kMostNames = 6;
  const auto names_of = [](const std::vector<Key>& keys) {
    std::string names;
    for (std::size_t i = 0; i < std::min(keys.size(), kMostNames); ++i) names += (i > 0 ? ", " : "") + keys[i].str();
    if (keys.size() > kMostNames) names += " and " + std::to_string(keys.size() - kMostNames) + " more";
    return names;
  };
  std::vector<Finding> findings;
  for (const MirrorImage& image : mirror_images(graph, values)) {
    const char* const surface = image.normal.size() == 3 ? "plane" : "line";
    std::ostringstream text;
    text << names_of(image.points) << (image.points.size() > 1 ? " fit" : " fits") << " as well on the other side of the " << surface
         << " of " << names_of(image.anchors) << ": nothing measured says which side is true; add a prior, a bearing or an anchor off the "
         << surface << ", or look at both (mirrored(), solve --mirror)";
    findings.push_back({Kind::mirror_image, Severity::warning, text.str(), image.points});
  }
  return findings;
}

Finding zero_distance(const Graph& graph, const Values& values) {
  constexpr std::size_t kMostNamed = 5;
  const Resolved resolved(graph, values);
  std::vector<std::string> names;
  std::set<Key> keys;
  for (std::size_t b = 0; b < graph.batches().size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    if (batch.is_linear()) continue;
    Eigen::VectorXd r(batch.residual_dim());
    Eigen::MatrixXd J(batch.residual_dim(), batch.total_dim());
    for (int i = 0; i < batch.size(); ++i) {
      batch.evaluate(values, resolved.batches()[b].index.data(), i, i + 1, r.data(), J.data());
      if (r.isZero(0) || !J.isZero(0)) continue;
      names.push_back(batch.describe(i));
      keys.insert(batch.keys(i), batch.keys(i) + batch.arity());
    }
  }
  std::ostringstream text;
  text << names.size() << (names.size() == 1 ? " factor stands" : " factors stand")
       << " at zero distance, where a residual has no derivative: ";
  for (std::size_t i = 0; i < std::min(names.size(), kMostNamed); ++i) text << (i > 0 ? ", " : "") << names[i];
  if (names.size() > kMostNamed) text << " and " << names.size() - kMostNamed << " more";
  text << "; the cost falls in every direction, and which one is taken is chance: give these variables a start apart (odometry, convex)";
  return {Kind::zero_distance, Severity::warning, text.str(), {keys.begin(), keys.end()}};
}

std::vector<Finding> merged(const std::vector<Finding>& findings) {
  constexpr std::size_t kMostAlone = 3, kMostNamed = 8;
  std::map<std::pair<Kind, Severity>, std::vector<const Finding*>> alike;
  for (const Finding& one : findings) alike[{one.kind, one.severity}].push_back(&one);
  std::vector<Finding> result;
  for (const Finding& one : findings) {
    const auto& group = alike[{one.kind, one.severity}];
    if (group.size() <= kMostAlone) {
      result.push_back(one);
      continue;
    }
    if (group.front() != &one) continue;
    Finding first = one;
    std::string others;
    std::size_t named = 0;
    std::set<Key> seen(one.keys.begin(), one.keys.end());
    for (const Finding* more : group)
      for (const Key key : more->keys) {
        if (!seen.insert(key).second) continue;
        first.keys.push_back(key);
        if (++named <= kMostNamed) others += (named > 1 ? ", " : "") + key.str();
      }
    if (named > kMostNamed) others += " and " + std::to_string(named - kMostNamed) + " more";
    first.text += "; and the same " + std::to_string(group.size() - 1) + " times more" + (others.empty() ? "" : ": " + others);
    result.push_back(std::move(first));
  }
  return result;
}

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
                                      "zero distance",
                                      "mirror image",
                                      "fixed is unknown",
                                      "bad time",
                                      "repaired noise",
                                      "no noise",
                                      "noise of iSAM"};
  return names[static_cast<int>(kind)];
}

}  // namespace holdfast
