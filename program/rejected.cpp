#include <algorithm>
#include <cmath>
#include <holdfast/graph/dynamic_covariance_scaling.hpp>
#include <holdfast/program/rejected.hpp>
#include <holdfast/solvers/chi_square.hpp>
#include <holdfast/solvers/outlier_report.hpp>
#include <sstream>

namespace holdfast::program {

bool has_threshold(const Loss& loss) {
  if (loss.kind == Loss::Kind::Own) return loss.own->type() == typeid(DynamicCovarianceScaling);
  return !loss.is_convex() && loss.kind != Loss::Kind::StudentT;
}

void set_thresholds(Graph& graph, double alpha) {
  std::vector<std::pair<FactorId, Loss>> changed;
  for (std::size_t b = 0; b < graph.batches().size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    if (!has_threshold(batch.family())) continue;
    for (int i = 0; i < batch.size(); ++i) {
      Loss loss = batch.loss(i);
      loss.scale = std::sqrt(chi_square_quantile(1 - alpha, loss.per_component ? 1 : batch.residual_dim()));
      if (loss.kind == Loss::Kind::Own) loss.own = Loss(DynamicCovarianceScaling{loss.scale}).own;
      changed.emplace_back(graph.id_of(static_cast<int>(b), i), loss);
    }
  }
  for (const auto& [id, loss] : changed) graph.set_loss(id, loss);
}

std::string rejected_list(const Graph& graph, const Values& answer, common::Json& run) {
  constexpr std::size_t kMost = 20;
  struct Rejected {
    std::string name;
    double chi_square;
    int components;
  };
  std::vector<Rejected> rejected;
  for (const MeasurementReport& one : outlier_report(graph, answer)) {
    if (one.verdict != MeasurementReport::Verdict::outlier) continue;
    const Graph::Place& place = graph.place(one.id);
    double s = 0;
    for (const double r : one.whitened) s += r * r;
    rejected.push_back({graph.batches()[place.batch]->describe(place.index), s, static_cast<int>(one.whitened.size())});
  }
  std::stable_sort(rejected.begin(), rejected.end(), [](const Rejected& a, const Rejected& b) { return a.chi_square > b.chi_square; });
  run["rejected"] = common::Json::array();
  for (const Rejected& one : rejected)
    run["rejected"].push_back({{"factor", one.name},
                               {"chi_square", one.chi_square},
                               {"components", one.components},
                               {"probability", chi_square_tail(one.chi_square, one.components)}});
  if (rejected.empty()) return "";
  std::ostringstream text;
  text.precision(3);
  text << "rejected by " << run["backend"].get<std::string>() << ", " << rejected.size() << ":";
  for (std::size_t i = 0; i < std::min(kMost, rejected.size()); ++i) {
    const double p = chi_square_tail(rejected[i].chi_square, rejected[i].components);
    text << (i == 0 ? " " : ", ") << rejected[i].name << " χ² = " << rejected[i].chi_square << " (p ";
    if (p > 0)
      text << "= " << p << ")";
    else
      text << "< 1e-300)";
  }
  if (rejected.size() > kMost) text << ", and " << rejected.size() - kMost << " more (--json has them all)";
  return text.str();
}

}  // namespace holdfast::program
