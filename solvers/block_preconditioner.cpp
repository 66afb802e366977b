#include <Eigen/Cholesky>
#include <algorithm>
#include <holdfast/solvers/block_preconditioner.hpp>

namespace holdfast {
namespace {

std::vector<int> free_variables(const Resolved& resolved) {
  std::vector<int> free;
  for (std::size_t v = 0; v < resolved.variables().size(); ++v)
    if (resolved.variables()[v].offset >= 0) free.push_back(static_cast<int>(v));
  return free;
}

}  // namespace

BlockPreconditioner::BlockPreconditioner(const Graph& graph, const Resolved& resolved) : normal_(graph, resolved, free_variables(resolved)) {
  std::size_t size = 0;
  for (int v : normal_.order()) {
    const Resolved::Variable& variable = resolved.variables()[v];
    offsets_.push_back(variable.offset);
    begin_.push_back(size);
    size += static_cast<std::size_t>(variable.dim) * variable.dim;
  }
  factors_.resize(size);
  traces_.assign(offsets_.size(), -1.0);
}

void BlockPreconditioner::update(const Graph& graph, const Resolved& resolved, const Values& values, ThreadPool* pool) {
  normal_.linearize(graph, resolved, values, Curvature::irls, pool);
  const BlockPattern& pattern = normal_.pattern();
  double largest = 0;
  std::vector<double> traces(traces_.size(), 0.0);
  for (int i = 0; i < pattern.size(); ++i) {
    const double* block = &normal_.H()[pattern.block_begin[pattern.column_begin[i]]];
    for (int c = 0; c < pattern.dims[i]; ++c) traces[i] += block[c * (pattern.dims[i] + 1)];
    largest = std::max(largest, traces[i] / pattern.dims[i]);
  }
  for (int i = 0; i < pattern.size(); ++i) {
    if (traces[i] <= traces_[i]) continue;
    traces_[i] = traces[i];
    // A block of a variable that only inactive one-sided factors touch is zero: it borrows the largest curvature there is.
    factor(i, traces[i] > 0 ? 1e-9 * traces[i] : std::max(largest, 1.0));
  }
}

void BlockPreconditioner::factor(int i, double floor) {
  const BlockPattern& pattern = normal_.pattern();
  const int d = pattern.dims[i];
  const double* block = &normal_.H()[pattern.block_begin[pattern.column_begin[i]]];
  Eigen::MatrixXd P = Eigen::Map<const Eigen::MatrixXd>(block, d, d);
  P.diagonal().array() += floor;
  Eigen::Map<Eigen::MatrixXd>(&factors_[begin_[i]], d, d) = P.llt().matrixL();
}

double BlockPreconditioner::apply(const std::vector<double>& g, std::vector<double>& out) const {
  out.resize(g.size());
  double product = 0;
  for (std::size_t i = 0; i < offsets_.size(); ++i) {
    const int d = normal_.pattern().dims[i];
    const Eigen::Map<const Eigen::MatrixXd> L(&factors_[begin_[i]], d, d);
    Eigen::Map<Eigen::VectorXd> x(&out[offsets_[i]], d);
    x = Eigen::Map<const Eigen::VectorXd>(&g[offsets_[i]], d);
    L.triangularView<Eigen::Lower>().solveInPlace(x);
    product += x.squaredNorm();
    L.transpose().triangularView<Eigen::Upper>().solveInPlace(x);
  }
  return product;
}

}  // namespace holdfast
