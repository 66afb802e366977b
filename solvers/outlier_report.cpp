#include <algorithm>
#include <cmath>
#include <holdfast/graph/resolved.hpp>
#include <holdfast/solvers/outlier_report.hpp>

namespace holdfast {
namespace {

double latest(const std::vector<Key>& keys, const std::unordered_map<Key, double>& times) {
  double time = NAN;
  for (Key key : keys) {
    const auto it = times.find(key);
    if (it != times.end()) time = std::isnan(time) ? it->second : std::max(time, it->second);
  }
  return time;
}

}  // namespace

double relative_weight(const Loss& loss, const double* r, int m) {
  double least = 1;
  if (loss.per_component || m == 1) {
    for (int c = 0; c < m; ++c)
      if (!(loss.one_sided && r[c] > 0)) least = std::min(least, loss.rho(r[c] * r[c], 1).first / loss.rho(0, 1).first);
    return least;
  }
  double s = 0;
  for (int c = 0; c < m; ++c) s += r[c] * r[c];
  return loss.rho(s, m).first / loss.rho(0, m).first;
}

std::vector<MeasurementReport> outlier_report(const Graph& graph, const Values& values, const std::unordered_map<Key, double>& times) {
  using Verdict = MeasurementReport::Verdict;
  const Resolved resolved(graph, values);
  std::vector<MeasurementReport> report;
  for (std::size_t b = 0; b < graph.batches().size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    if (batch.factor_type() == typeid(LinearPrior)) continue;
    const FactorType* type = find_factor_type(batch.factor_type());
    for (int i = 0; i < batch.size(); ++i) {
      MeasurementReport one{graph.id_of(static_cast<int>(b), i),
                            batch.name(),
                            {batch.keys(i), batch.keys(i) + batch.arity()},
                            0,
                            {},
                            {},
                            0,
                            Verdict::not_finite};
      one.time = latest(one.keys, times);
      one.whitened.resize(batch.residual_dim());
      one.raw.resize(batch.residual_dim());
      batch.evaluate(values, resolved.batches()[b].index.data(), i, i + 1, one.whitened.data(), nullptr);
      if (type == nullptr || !type->raw(batch, i, one.whitened.data(), one.raw.data())) one.raw.clear();
      if (std::isfinite(batch.cost_of(i, one.whitened.data(), nullptr))) {  // a residual whose square overflows is of no use either
        one.weight = relative_weight(batch.loss(i), one.whitened.data(), batch.residual_dim());
        one.verdict = is_rejected(one.weight) ? Verdict::outlier : Verdict::inlier;
      }
      report.push_back(std::move(one));
    }
  }
  return report;
}

const char* to_string(MeasurementReport::Verdict verdict) {
  static const char* const names[] = {"inlier", "outlier", "not finite"};
  return names[static_cast<int>(verdict)];
}

}  // namespace holdfast
