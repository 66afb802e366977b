#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <holdfast/graph/observability.hpp>
#include <holdfast/solvers/linear/internal/selected_inverse.hpp>

namespace holdfast {
namespace {

using Eigen::Lower;
using Eigen::MatrixXd;
using Eigen::OnTheRight;
using Eigen::VectorXd;

constexpr int kBlock = 48;       // columns eliminated before the rest of the front is updated
constexpr double kMoves = 1e-6;  // of the largest entry, in that metric: what a null vector does not move

}  // namespace

SelectedInverse::SelectedInverse(Symbolic symbolic, const BlockPattern& pattern, const std::vector<double>& H)
    : symbolic_(std::move(symbolic)), pattern_(pattern), front_of_(pattern.size()), free_(pattern.size(), false) {
  diagonal_.resize(pattern_.scalar_size());
  for (int i = 0; i < pattern_.size(); ++i)
    for (int c = 0; c < pattern_.dims[i]; ++c)
      diagonal_[pattern_.offsets[i] + c] = H[pattern_.block_begin[pattern_.column_begin[i]] + c * (pattern_.dims[i] + 1)];
  null_ = VectorXd::Zero(pattern_.scalar_size());
  make_fronts();
  factor(H);
  for (std::size_t s = fronts_.size(); s-- > 0;) invert(static_cast<int>(s));
}

void SelectedInverse::make_fronts() {
  fronts_.resize(symbolic_.supernodes.size());
  for (std::size_t s = 0; s < fronts_.size(); ++s) {
    const Symbolic::Supernode& supernode = symbolic_.supernodes[s];
    Front& front = fronts_[s];
    front.first_scalar = pattern_.offsets[supernode.first];
    front.k = supernode.k;
    front.n = supernode.n;
    std::fill(front_of_.begin() + supernode.first, front_of_.begin() + supernode.last, static_cast<int>(s));
    int row = front.k;
    for (int block : supernode.rows) {
      front.row_begin.push_back(row);
      row += pattern_.dims[block];
    }
    front.first_descendant = static_cast<int>(s);
    for (int c : front.children) front.first_descendant = std::min(front.first_descendant, fronts_[c].first_descendant);
    if (supernode.parent >= 0) fronts_[supernode.parent].children.push_back(static_cast<int>(s));
  }
}

// The first scalar row of a block in a front; −1 where it has none.
int SelectedInverse::row_in_front(int s, int block) const {
  const Symbolic::Supernode& supernode = symbolic_.supernodes[s];
  if (block < supernode.last) return block < supernode.first ? -1 : pattern_.offsets[block] - fronts_[s].first_scalar;
  const auto it = std::lower_bound(supernode.rows.begin(), supernode.rows.end(), block);
  return it != supernode.rows.end() && *it == block ? fronts_[s].row_begin[it - supernode.rows.begin()] : -1;
}

void SelectedInverse::factor(const std::vector<double>& H) {
  std::vector<MatrixXd> updates(fronts_.size());
  for (std::size_t s = 0; s < fronts_.size(); ++s) {
    Front& front = fronts_[s];
    MatrixXd F = assemble(static_cast<int>(s), H, updates);
    eliminate(static_cast<int>(s), F);
    front.L = F.leftCols(front.k);
    updates[s] = F.bottomRightCorner(front.n - front.k, front.n - front.k);
  }
}

// Lower triangle: the own columns of H, and what the children leave.
MatrixXd SelectedInverse::assemble(int s, const std::vector<double>& H, std::vector<MatrixXd>& updates) {
  const Symbolic::Supernode& supernode = symbolic_.supernodes[s];
  MatrixXd F = MatrixXd::Zero(fronts_[s].n, fronts_[s].n);
  for (int column = supernode.first; column < supernode.last; ++column)
    for (int b = pattern_.column_begin[column]; b < pattern_.column_begin[column + 1]; ++b) {
      const int rows = pattern_.dims[pattern_.rows[b]], cols = pattern_.dims[column];
      F.block(row_in_front(s, pattern_.rows[b]), row_in_front(s, column), rows, cols) =
          Eigen::Map<const MatrixXd>(H.data() + pattern_.block_begin[b], rows, cols);
    }
  for (int c : fronts_[s].children) {
    const std::vector<int>& blocks = symbolic_.supernodes[c].rows;
    std::vector<int> to, from;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      to.push_back(row_in_front(s, blocks[i]));
      from.push_back(fronts_[c].row_begin[i] - fronts_[c].k);
    }
    for (std::size_t j = 0; j < blocks.size(); ++j)
      for (std::size_t i = j; i < blocks.size(); ++i) {
        const int rows = pattern_.dims[blocks[i]], cols = pattern_.dims[blocks[j]];
        F.block(to[i], to[j], rows, cols) += updates[c].block(from[i], from[j], rows, cols);
      }
    updates[c].resize(0, 0);
  }
  return F;
}

void SelectedInverse::eliminate(int s, MatrixXd& F) {
  const int k = fronts_[s].k, n = fronts_[s].n;
  for (int begin = 0; begin < k; begin += kBlock) {
    const int end = std::min(k, begin + kBlock);
    for (int c = begin; c < end; ++c) {
      F.col(c).tail(n - c).noalias() -= F.block(c, begin, n - c, c - begin) * F.row(c).segment(begin, c - begin).transpose();
      if (pivot_vanishes(s, F, c)) {
        const double diagonal = diagonal_[fronts_[s].first_scalar + c];
        F(c, c) = diagonal > 0 ? diagonal : 1;
      }
      F(c, c) = std::sqrt(F(c, c));
      F.col(c).tail(n - c - 1) /= F(c, c);
    }
    if (end < n) F.bottomRightCorner(n - end, n - end).selfadjointView<Lower>().rankUpdate(F.block(end, begin, n - end, end - begin), -1.0);
  }
}

// The pivot is zᵀ H z of the vector z, zero after this column and 1 in it, that minimises it. It is compared with zᵀ diag(H) z and not
// with its own diagonal entry: where z is a rotation of a large map, rounding errors of far variables are what is left of the pivot.
bool SelectedInverse::pivot_vanishes(int s, const MatrixXd& F, int column) {
  const int scalar = fronts_[s].first_scalar + column;
  if (F(column, column) > detail::kSuspectPivot * diagonal_[scalar]) return false;
  const double energy = extend_to_null_vector(s, F, column);
  const bool vanishes = detail::is_unobservable(F(column, column), energy);
  const int begin = fronts_[fronts_[s].first_descendant].first_scalar;
  if (vanishes) note_free(begin, scalar);
  null_.segment(begin, scalar + 1 - begin).setZero();
  return vanishes;
}

// Fills null_ with that z by back substitution through the columns before this one; returns zᵀ diag(H) z.
double SelectedInverse::extend_to_null_vector(int s, const MatrixXd& F, int column) {
  const Front& front = fronts_[s];
  auto own = null_.segment(front.first_scalar, column);
  own = -F.row(column).head(column).transpose();
  F.topLeftCorner(column, column).triangularView<Lower>().transpose().solveInPlace(own);
  null_[front.first_scalar + column] = 1;
  for (int t = s - 1; t >= front.first_descendant; --t) {
    const Front& f = fronts_[t];
    VectorXd x = -f.L.bottomRows(f.n - f.k).transpose() * below(f, symbolic_.supernodes[t], null_);
    f.L.topRows(f.k).triangularView<Lower>().transpose().solveInPlace(x);
    null_.segment(f.first_scalar, f.k) = x;
  }
  const int begin = fronts_[front.first_descendant].first_scalar, size = front.first_scalar + column + 1 - begin;
  return null_.segment(begin, size).cwiseAbs2().dot(diagonal_.segment(begin, size));
}

void SelectedInverse::note_free(int begin, int pivot) {
  double largest = 0;
  for (int i = begin; i <= pivot; ++i) largest = std::max(largest, std::abs(null_[i]) * std::sqrt(diagonal_[i]));
  const auto block_of = [&](int scalar) {
    return static_cast<int>(std::upper_bound(pattern_.offsets.begin(), pattern_.offsets.end(), scalar) - pattern_.offsets.begin()) - 1;
  };
  free_[block_of(pivot)] = true;  // also where its diagonal is zero
  for (int b = block_of(begin); b <= block_of(pivot); ++b)
    for (int i = pattern_.offsets[b]; i < pattern_.offsets[b + 1]; ++i)
      if (std::abs(null_[i]) * std::sqrt(diagonal_[i]) > kMoves * largest) free_[b] = true;
}

void SelectedInverse::invert(int s) {
  Front& front = fronts_[s];
  const Symbolic::Supernode& supernode = symbolic_.supernodes[s];
  const int k = front.k, m = front.n - front.k;
  const auto L_own = front.L.topRows(k).triangularView<Lower>();
  MatrixXd inverse = MatrixXd::Identity(k, k);
  L_own.solveInPlace(inverse);
  front.Z.resize(front.n, k);
  front.Z.topRows(k).noalias() = inverse.transpose() * inverse;
  if (m == 0) return;  // a root

  MatrixXd Z_below(m, m);  // lower triangle
  for (std::size_t j = 0; j < supernode.rows.size(); ++j) {
    const int above = front_of_[supernode.rows[j]];
    for (std::size_t i = j; i < supernode.rows.size(); ++i) {
      const auto block = stored(above, supernode.rows[i], supernode.rows[j]);
      Z_below.block(front.row_begin[i] - k, front.row_begin[j] - k, block.rows(), block.cols()) = block;
    }
  }
  MatrixXd W = front.L.bottomRows(m);
  L_own.solveInPlace<OnTheRight>(W);
  front.Z.bottomRows(m).noalias() = -(Z_below.selfadjointView<Lower>() * W);
  const MatrixXd Z_own = front.Z.topRows(k) - W.transpose() * front.Z.bottomRows(m);
  front.Z.topRows(k) = 0.5 * (Z_own + Z_own.transpose());
}

// Block (row, column) of a front that owns `column`, row >= column.
Eigen::Block<const MatrixXd> SelectedInverse::stored(int s, int row, int column) const {
  return fronts_[s].Z.block(row_in_front(s, row), row_in_front(s, column), pattern_.dims[row], pattern_.dims[column]);
}

MatrixXd SelectedInverse::block(int row, int column) const {
  const int first = std::min(row, column), last = std::max(row, column), s = front_of_[first];
  if (row_in_front(s, last) >= 0) return row == last ? MatrixXd(stored(s, last, first)) : MatrixXd(stored(s, last, first).transpose());
  MatrixXd result(pattern_.dims[row], pattern_.dims[column]);
  for (int c = 0; c < result.cols(); ++c) {
    VectorXd x = VectorXd::Unit(pattern_.scalar_size(), pattern_.offsets[column] + c);
    solve_in_place(x);
    result.col(c) = x.segment(pattern_.offsets[row], pattern_.dims[row]);
  }
  return result;
}

// The entries of x in the rows below a front's own.
VectorXd SelectedInverse::below(const Front& front, const Symbolic::Supernode& supernode, const VectorXd& x) const {
  VectorXd rows(front.n - front.k);
  for (std::size_t i = 0; i < supernode.rows.size(); ++i)
    rows.segment(front.row_begin[i] - front.k, pattern_.dims[supernode.rows[i]]) =
        x.segment(pattern_.offsets[supernode.rows[i]], pattern_.dims[supernode.rows[i]]);
  return rows;
}

void SelectedInverse::solve_in_place(VectorXd& x) const {
  for (std::size_t s = 0; s < fronts_.size(); ++s) {  // L y = b
    const Front& f = fronts_[s];
    auto own = x.segment(f.first_scalar, f.k);
    f.L.topRows(f.k).triangularView<Lower>().solveInPlace(own);
    const VectorXd update = f.L.bottomRows(f.n - f.k) * own;
    const std::vector<int>& rows = symbolic_.supernodes[s].rows;
    for (std::size_t i = 0; i < rows.size(); ++i)
      x.segment(pattern_.offsets[rows[i]], pattern_.dims[rows[i]]) -= update.segment(f.row_begin[i] - f.k, pattern_.dims[rows[i]]);
  }
  for (std::size_t s = fronts_.size(); s-- > 0;) {  // Lᵀ x = y
    const Front& f = fronts_[s];
    auto own = x.segment(f.first_scalar, f.k);
    own -= f.L.bottomRows(f.n - f.k).transpose() * below(f, symbolic_.supernodes[s], x);
    f.L.topRows(f.k).triangularView<Lower>().transpose().solveInPlace(own);
  }
}

}  // namespace holdfast
