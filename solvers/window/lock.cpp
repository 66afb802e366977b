// What an agent that keeps lock remembers.
#include <Eigen/QR>
#include <algorithm>
#include <holdfast/solvers/window/detail/lock.hpp>

namespace holdfast {

void LockOptions::validate() const {
  if (memory < 2) fail<BadOption>("memory = ", memory, " must be >= 2 states");
  if (recent < 1) fail<BadOption>("recent = ", recent, " must be >= 1 measurement");
  if (!(rejected > 0)) fail<BadOption>("rejected = ", rejected, " must be > 0 [sigmas]");
  if (patience < 1) fail<BadOption>("patience = ", patience, " must be >= 1 state");
  if (settled < 0) fail<BadOption>("settled = ", settled, " must be >= 0 states");
}

namespace detail {
namespace {

/// r, and unless J is null its Jacobian, of one factor; returns the batch.
const FactorBatch& evaluate(const Graph& graph, const Values& values, FactorId id, std::vector<double>& r, std::vector<double>* J) {
  const Graph::Place& place = graph.place(id);
  const FactorBatch& batch = *graph.batches()[place.batch];
  constexpr int kMost = 16;
  const double* ambient[kMost];
  std::vector<const double*> many(batch.arity() > kMost ? batch.arity() : 0);
  const double** const x = many.empty() ? ambient : many.data();
  for (int k = 0; k < batch.arity(); ++k) {
    const Values::Slot& slot = values.slot(batch.keys(place.index)[k]);
    x[k] = values.pool(slot.pool).data(slot.index);
  }
  r.resize(batch.residual_dim());
  if (J != nullptr) J->resize(static_cast<std::size_t>(batch.residual_dim()) * batch.total_dim());
  batch.evaluate_at(place.index, x, r.data(), J == nullptr ? nullptr : J->data());
  return batch;
}

}  // namespace

void Lock::leave(Key key, double time, const Values& from, std::size_t held) {
  copy_variable(key, from, values);
  left.push_back({key, time});
  while (!left.empty() && left.size() + held > static_cast<std::size_t>(options.memory)) {
    const Key oldest = left.front().key;
    marginalizer.drop(memory, oldest);
    values.erase(oldest);
    left.erase(left.begin());
    const auto begin = std::remove_if(measured.begin(), measured.end(), [&](const Measured& one) { return one.state == oldest; });
    fresh -= std::min(fresh, static_cast<std::size_t>(measured.end() - begin));
    measured.erase(begin, measured.end());
  }
}

void Lock::forget(FactorId id) {
  for (std::size_t i = 0; i < measured.size(); ++i) {
    if (measured[i].id.number != id.number || measured[i].id.generation != id.generation) continue;
    if (memory.contains(measured[i].copy)) memory.remove(measured[i].copy);
    measured.erase(measured.begin() + static_cast<std::ptrdiff_t>(i));
    if (i < fresh) --fresh;
    return;
  }
}

void Lock::forget(Key landmark) { marginalizer.drop(memory, landmark); }

double residual_norm(const Graph& graph, const Values& values, FactorId id) {
  static thread_local std::vector<double> r;
  evaluate(graph, values, id, r, nullptr);
  return Eigen::Map<const Eigen::VectorXd>(r.data(), static_cast<Eigen::Index>(r.size())).norm();
}

void move_to_measurement(const Graph& graph, Values& values, FactorId id, Key key) {
  constexpr int kSteps = 20;
  constexpr double kArrived = 1e-9;  // [sigmas]
  std::vector<double> r, J;
  const Values::Slot slot = values.slot(key);
  PoolBase& pool = values.pool(slot.pool);
  std::vector<double> moved(pool.ambient());
  for (int step = 0; step < kSteps; ++step) {
    const FactorBatch& batch = evaluate(graph, values, id, r, &J);
    const Key* const keys = batch.keys(graph.place(id).index);
    const int m = batch.residual_dim();
    int column = 0, k = 0;
    for (; keys[k] != key; ++k) column += batch.dims()[k];
    const Eigen::Map<const Eigen::VectorXd> residual(r.data(), m);
    const Eigen::Map<const Eigen::MatrixXd> jacobian(J.data() + static_cast<std::ptrdiff_t>(column) * m, m, batch.dims()[k]);
    if (!residual.allFinite() || !jacobian.allFinite() || residual.norm() < kArrived) return;
    const Eigen::VectorXd delta = jacobian.completeOrthogonalDecomposition().solve(-residual);
    pool.retract_ambient(pool.data(slot.index), delta.data(), moved.data());
    std::copy(moved.begin(), moved.end(), pool.data(slot.index));
    if (batch.is_linear()) return;
  }
}

void copy_variable(Key key, const Values& from, Values& to) {
  const Values::Slot& slot = from.slot(key);
  const PoolBase& pool = from.pool(slot.pool);
  if (!to.contains(key)) return to.insert_ambient(key, pool.kind(), pool.data(slot.index));
  const Values::Slot& place = to.slot(key);
  std::copy_n(pool.data(slot.index), pool.ambient(), to.pool(place.pool).data(place.index));
}

}  // namespace detail
}  // namespace holdfast
