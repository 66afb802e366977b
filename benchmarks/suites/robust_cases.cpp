#include <algorithm>
#include <holdfast/benchmarks/suites/robust_cases.hpp>
#include <holdfast/common/table.hpp>
#include <holdfast/graph/dynamic_covariance_scaling.hpp>
#include <holdfast/graph/switchable_constraint.hpp>
#include <holdfast/solvers/table.hpp>

namespace holdfast::bench {
namespace {

std::vector<RobustMethod> all_methods() {
  const auto squared = [](double) { return Loss(Squared{}); };
  const auto truncated = [](double c) { return Loss(TruncatedSquares{c}); };
  std::vector<RobustMethod> all{{"squared", "irls", squared},
                                {"huber", "irls", [](double) { return Loss(Huber{1.345}); }},
                                {"pseudo_huber", "irls", [](double) { return Loss(PseudoHuber{1.345}); }},
                                {"absolute", "irls", [](double) { return Loss(Absolute{}); }},
                                {"cauchy", "irls", [](double) { return Loss(Cauchy{1}); }},
                                {"geman_mcclure", "irls", [](double c) { return Loss(GemanMcClure{c}); }},
                                {"welsch", "irls", [](double c) { return Loss(Welsch{c}); }},
                                {"tukey", "irls", [](double c) { return Loss(Tukey{c}); }},
                                {"student_t", "irls", [](double) { return Loss(StudentT{3}); }},
                                {"dcs", "irls", [](double c) { return Loss(DynamicCovarianceScaling{c}); }},
                                {"switchable", "irls", [](double) { return Loss(SwitchableConstraint{1}); }},
                                {"truncated_squares", "irls", truncated},
                                {"gnc-irls", "gnc-irls", truncated},
                                {"gnc-irls one_sided", "gnc-irls", [](double c) { return one_sided(TruncatedSquares{c}); }, false, true}};
  const std::vector<std::string> names = backend_names();
  if (std::count(names.begin(), names.end(), "ceres") != 0) all.push_back({"gnc-ceres", "gnc-ceres", truncated});
  all.push_back({"pcm + squared", "irls", squared, true});
  all.push_back({"pcm + gnc-irls", "gnc-irls", truncated, true});
  return all;
}

std::vector<RobustSetting> all_settings() {
  using Loops = FalseLoops::Kind;
  using Ranges = FalseRanges::Kind;
  std::vector<RobustSetting> all;
  for (const char* graph : {"CSAIL", "intel", "MIT", "M3500"}) {
    for (const Loops kind : {Loops::random, Loops::at_one_place})
      for (const double share : {0.1, 0.5, 1.0, 2.0, 3.0}) all.push_back({graph, FalseLoops{kind, share}});
    for (const Loops kind : {Loops::local, Loops::grouped, Loops::local_groups})
      for (const double share : {0.1, 0.5}) all.push_back({graph, FalseLoops{kind, share}});
  }
  for (const char* graph : {"smallGrid3D", "sphere2500"})
    for (const Loops kind : {Loops::random, Loops::near_truth})
      for (const double share : {0.1, 0.5, 1.0}) all.push_back({graph, FalseLoops{kind, share}});
  for (const char* graph : {"plaza2", "single_drone", "tiers"}) {
    for (const double share : {0.1, 0.4, 0.6}) all.push_back({graph, FalseRanges{Ranges::echoes, share}});
    all.push_back({graph, FalseRanges{Ranges::no_line_of_sight, 0.4}});
  }
  all.push_back({"goats_14", FalseRanges{Ranges::as_it_is, 0}});
  return all;
}

/// Keeps of `all` what has one of the wanted names (all, where none is wanted). Throws BadOption where nothing has one of them.
template <class T, class NameOf>
void choose(std::vector<T>& all, const std::vector<std::string>& wanted, const char* option, const NameOf& name_of) {
  if (wanted.empty()) return;
  const auto has = [&](const T& one, const std::string& name) { return name_of(one) == name; };
  for (const std::string& name : wanted) {
    if (std::any_of(all.begin(), all.end(), [&](const T& one) { return has(one, name); })) continue;
    std::vector<std::string> names;
    std::string known;
    for (const T& one : all)
      if (std::find(names.begin(), names.end(), name_of(one)) == names.end()) names.push_back(name_of(one));
    for (const std::string& one : names) known += (known.empty() ? " " : ", ") + one;
    fail<BadOption>(option, ": of what is left to choose from there is no '", name, "'; there are:", known);
  }
  all.erase(std::remove_if(all.begin(), all.end(),
                           [&](const T& one) {
                             return std::none_of(wanted.begin(), wanted.end(), [&](const std::string& name) { return has(one, name); });
                           }),
            all.end());
}

}  // namespace

std::string RobustSetting::kind() const {
  return std::visit([](const auto& one) { return std::string(to_string(one.kind)); }, attack);
}
double RobustSetting::share() const {
  return std::visit([](const auto& one) { return one.share; }, attack);
}
std::optional<AttackedGraph> RobustSetting::make(unsigned seed) const {
  return std::visit([&](const auto& one) { return attacked(graph, one, seed); }, attack);
}

std::vector<RobustMethod> robust_methods(const RunnerOptions& options) {
  std::vector<RobustMethod> all = all_methods();
  choose(all, options.methods, "--methods", [](const RobustMethod& one) { return one.name; });
  return all;
}

std::vector<RobustSetting> robust_settings(const RunnerOptions& options) {
  std::vector<RobustSetting> all = all_settings();
  choose(all, options.graphs, "--graphs", [](const RobustSetting& one) { return std::string(one.graph); });
  choose(all, options.kinds, "--kinds", [](const RobustSetting& one) { return one.kind(); });
  std::vector<std::string> shares;
  for (const double share : options.shares) shares.push_back(common::cell("%g", share));
  choose(all, shares, "--shares", [](const RobustSetting& one) { return common::cell("%g", one.share()); });
  return all;
}

}  // namespace holdfast::bench
