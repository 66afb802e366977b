#include <Eigen/Geometry>
#include <algorithm>
#include <holdfast/common/metrics.hpp>
#include <holdfast/graph/resolved.hpp>
#include <holdfast/solvers/outlier_report.hpp>

namespace holdfast::common {
namespace {

/// Side by side, one column a variable.
struct Positions {
  Eigen::MatrixXd truth, estimate;
};

Positions common_positions(const Values& truth, const Values& estimate) {
  std::vector<double> t, e;
  int space = 0;
  for (const auto& pool : truth.pools()) {
    if (pool->size() == 0 || pool->space() == 0 || (space != 0 && pool->space() != space)) continue;
    space = pool->space();
    for (int i = 0; i < pool->size(); ++i) {
      if (!estimate.contains(pool->keys()[i])) continue;
      const Values::Slot& slot = estimate.slot(pool->keys()[i]);
      if (estimate.pool(slot.pool).space() != space) continue;
      t.resize(t.size() + space);
      e.resize(e.size() + space);
      pool->position(i, t.data() + t.size() - space);
      estimate.pool(slot.pool).position(slot.index, e.data() + e.size() - space);
    }
  }
  const Eigen::Index count = space == 0 ? 0 : static_cast<Eigen::Index>(t.size()) / space;
  return {Eigen::Map<Eigen::MatrixXd>(t.data(), space, count), Eigen::Map<Eigen::MatrixXd>(e.data(), space, count)};
}

double rms_of_columns(const Eigen::MatrixXd& m) { return std::sqrt(m.squaredNorm() / static_cast<double>(m.cols())); }

}  // namespace

std::optional<Eigen::MatrixXd> alignment(const Values& truth, const Values& estimate) {
  const auto [t, e] = common_positions(truth, estimate);
  if (t.cols() == 0) return std::nullopt;
  return Eigen::umeyama(e, t, false);
}

std::optional<PositionError> position_error(const Values& truth, const Values& estimate) {
  const auto [t, e] = common_positions(truth, estimate);
  if (t.cols() == 0) return std::nullopt;
  const Eigen::Index space = t.rows();
  const Eigen::MatrixXd T_truth_estimate = Eigen::umeyama(e, t, false);
  const Eigen::MatrixXd aligned =
      (T_truth_estimate.topLeftCorner(space, space) * e).colwise() + T_truth_estimate.topRightCorner(space, 1).col(0);
  return PositionError{rms_of_columns(aligned - t), rms_of_columns(e - t), static_cast<std::size_t>(t.cols())};
}

RejectedCount count_rejected(const Graph& graph, const Values& values) {
  const Resolved resolved(graph, values);
  RejectedCount count;
  std::vector<double> residuals;
  for (std::size_t b = 0; b < graph.batches().size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    const bool is_range = batch.name().rfind("Range", 0) == 0, is_judged = batch.family().kind != Loss::Kind::Squared;
    if (!is_range && !is_judged) continue;
    const int dim = batch.residual_dim();
    residuals.resize(static_cast<std::size_t>(batch.size()) * dim);
    batch.evaluate(values, resolved.batches()[b].index.data(), 0, batch.size(), residuals.data(), nullptr);
    std::size_t rejected = 0;
    for (int i = 0; i < batch.size(); ++i)
      if (is_rejected(relative_weight(batch.loss(i), &residuals[static_cast<std::size_t>(i) * dim], dim))) ++rejected;
    if (is_range) {
      count.ranges += batch.size();
      count.rejected_ranges += rejected;
    }
    if (is_judged) {
      count.judged += batch.size();
      count.rejected += rejected;
    }
  }
  return count;
}

}  // namespace holdfast::common
