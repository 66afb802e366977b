#include <Eigen/OrderingMethods>
#include <Eigen/SparseCholesky>
#include <holdfast/solvers/block_cholesky.hpp>
#include <numeric>

namespace holdfast {

using Sparse = Eigen::SparseMatrix<double>;

std::vector<int> elimination_order(const Graph& graph, const Resolved& resolved) {
  std::vector<int> free;
  for (std::size_t v = 0; v < resolved.variables().size(); ++v)
    if (resolved.variables()[v].offset >= 0) free.push_back(static_cast<int>(v));
  const NormalEquations natural(graph, resolved, free);
  const BlockPattern& pattern = natural.pattern();
  std::vector<Eigen::Triplet<double>> entries;
  for (int column = 0; column < pattern.size(); ++column)
    for (int k = pattern.column_begin[column]; k < pattern.column_begin[column + 1]; ++k) {
      entries.emplace_back(pattern.rows[k], column, 1.0);
      entries.emplace_back(column, pattern.rows[k], 1.0);
    }
  Sparse adjacency(pattern.size(), pattern.size());
  adjacency.setFromTriplets(entries.begin(), entries.end());
  Eigen::AMDOrdering<int>::PermutationType permutation;
  Eigen::AMDOrdering<int>()(adjacency, permutation);
  std::vector<int> order(free.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = free[permutation.indices()[static_cast<Eigen::Index>(i)]];
  return order;
}

struct BlockCholesky::Impl {
  const BlockPattern* pattern;
  Sparse matrix;
  std::vector<Eigen::Index> place;     // of each lower scalar entry of H, in H's own order (−1: above the diagonal)
  std::vector<Eigen::Index> diagonal;  // in matrix
  Eigen::SimplicialLLT<Sparse, Eigen::Lower, Eigen::NaturalOrdering<int>> cholesky;
};

BlockCholesky::BlockCholesky(const BlockPattern& pattern) : impl_(std::make_unique<Impl>()) {
  impl_->pattern = &pattern;
  std::vector<Eigen::Triplet<double>> entries;
  const auto for_each_entry = [&](const auto& visit) {
    for (int column = 0; column < pattern.size(); ++column)
      for (int k = pattern.column_begin[column]; k < pattern.column_begin[column + 1]; ++k) {
        const int row = pattern.rows[k];
        for (int c = 0; c < pattern.dims[column]; ++c)
          for (int r = 0; r < pattern.dims[row]; ++r) visit(pattern.offsets[row] + r, pattern.offsets[column] + c);
      }
  };
  for_each_entry([&](int row, int column) {
    if (row >= column) entries.emplace_back(row, column, 1.0);
  });
  impl_->matrix.resize(pattern.scalar_size(), pattern.scalar_size());
  impl_->matrix.setFromTriplets(entries.begin(), entries.end());
  for_each_entry([&](int row, int column) { impl_->place.push_back(row >= column ? &impl_->matrix.coeffRef(row, column) - impl_->matrix.valuePtr() : -1); });
  for (int i = 0; i < pattern.scalar_size(); ++i) impl_->diagonal.push_back(&impl_->matrix.coeffRef(i, i) - impl_->matrix.valuePtr());
  impl_->cholesky.analyzePattern(impl_->matrix);
}

BlockCholesky::~BlockCholesky() = default;
BlockCholesky::BlockCholesky(BlockCholesky&&) noexcept = default;
BlockCholesky& BlockCholesky::operator=(BlockCholesky&&) noexcept = default;

bool BlockCholesky::factor(const std::vector<double>& H, const std::vector<double>& damping) {
  double* values = impl_->matrix.valuePtr();
  for (std::size_t k = 0; k < H.size(); ++k)
    if (impl_->place[k] >= 0) values[impl_->place[k]] = H[k];
  for (std::size_t i = 0; i < damping.size(); ++i) values[impl_->diagonal[i]] += damping[i];
  impl_->cholesky.factorize(impl_->matrix);
  return impl_->cholesky.info() == Eigen::Success;
}

void BlockCholesky::solve(const std::vector<double>& b, std::vector<double>& x) const {
  const auto n = static_cast<Eigen::Index>(b.size());
  Eigen::Map<Eigen::VectorXd>(x.data(), n) = impl_->cholesky.solve(Eigen::Map<const Eigen::VectorXd>(b.data(), n));
}

}  // namespace holdfast
