#include <holdfast/solvers/irls/internal/linear_descent.hpp>

namespace holdfast::detail {

void LinearFronts::load(const Graph& graph, const Values& values) {
  const std::size_t batches = graph.batches().size();
  for (auto* arrays : {&r_, &J_, &Jd_, &row_weights_}) arrays->resize(batches);
  for (std::size_t b = 0; b < batches; ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    const std::size_t rows = static_cast<std::size_t>(batch.size()) * batch.residual_dim();
    r_[b].resize(rows);
    Jd_[b].resize(rows);
    row_weights_[b].resize(rows);
    weights_of_rows(batch, row_weights_[b].data());
    J_[b].resize(rows * batch.total_dim());
    batch.evaluate(values, resolved().batches()[b].index.data(), 0, batch.size(), r_[b].data(), J_[b].data());
  }
  step_.resize(system_.size());
  tangent_.resize(system_.size());
  total_.assign(system_.size(), 0.0);
}

void LinearFronts::apply_step(const Graph& graph) {
  system_.to_tangent(step_, tangent_);
  for (std::size_t b = 0; b < r_.size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    batch.apply_jacobians(J_[b].data(), offsets_[b].data(), 0, batch.size(), tangent_.data(), Jd_[b].data());
  }
}

Phi LinearFronts::phi(const Graph& graph, double alpha) const {
  Phi sum;
  for (std::size_t b = 0; b < r_.size(); ++b)
    sum += phi_of_batch(*graph.batches()[b], row_weights_[b].data(), r_[b].data(), Jd_[b].data(), alpha);
  return sum;
}

void LinearFronts::move_along(double alpha) {
  for (std::size_t b = 0; b < r_.size(); ++b)
    for (std::size_t k = 0; k < r_[b].size(); ++k) r_[b][k] += alpha * Jd_[b][k];
  for (std::size_t k = 0; k < tangent_.size(); ++k) total_[k] += alpha * tangent_[k];
}

}  // namespace holdfast::detail
