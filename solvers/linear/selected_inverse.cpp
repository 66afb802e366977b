#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <holdfast/graph/observability.hpp>
#include <holdfast/solvers/linear/internal/dense_kernels.hpp>
#include <holdfast/solvers/linear/internal/selected_inverse.hpp>

namespace holdfast {
namespace {

using Eigen::Lower;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Padded = Eigen::Map<MatrixXd>;

/// A matrix of `rows` (a leading dimension) × `columns` in a buffer, with what the kernels read and write beyond it.
Padded padded(std::vector<double>& buffer, int rows, int columns) {
  const std::size_t size = static_cast<std::size_t>(rows) * (columns + 1);
  if (buffer.size() < size) buffer.resize(size);
  return {buffer.data(), rows, columns};
}

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
    front.ld = dense::leading_dimension(front.n);
    front.parent = supernode.parent;
    std::fill(front_of_.begin() + supernode.first, front_of_.begin() + supernode.last, static_cast<int>(s));
    int row = front.k;
    for (int block : supernode.rows) {
      front.row_begin.push_back(row);
      row += pattern_.dims[block];
      for (int c = 0; c < pattern_.dims[block]; ++c) front.scalars.push_back(pattern_.offsets[block] + c);
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

// Where the rows below a front, from the given one on, are in a front above that has them.
std::vector<int> SelectedInverse::places_in(const Front& above, const Front& front, std::size_t from) const {
  std::vector<int> places;
  places.reserve(front.scalars.size() - from);
  std::size_t at = 0;
  for (std::size_t r = from; r < front.scalars.size(); ++r) {
    const int own = front.scalars[r] - above.first_scalar;
    if (own < above.k) {
      places.push_back(own);
      continue;
    }
    while (above.scalars[at] != front.scalars[r]) ++at;
    places.push_back(above.k + static_cast<int>(at));
  }
  return places;
}

void SelectedInverse::factor(const std::vector<double>& H) {
  std::vector<MatrixXd> updates(fronts_.size());
  for (std::size_t s = 0; s < fronts_.size(); ++s) {
    Front& front = fronts_[s];
    const int k = front.k, m = front.n - k;
    assemble(static_cast<int>(s), H, updates);
    const Padded F = padded(front_, front.ld, front.n);
    if (!eliminate_at_once(static_cast<int>(s))) {
      MatrixXd slow = F.topRows(front.n);
      eliminate(static_cast<int>(s), slow);
      front.L.topLeftCorner(front.n, k) = slow.leftCols(k);
      if (m > 0) updates[s] = slow.bottomRightCorner(m, m);
    } else if (m > 0) {
      const int ld = dense::leading_dimension(m);
      MatrixXd& update = updates[s];
      update.resize(ld, m + 1);
      dense::negative_outer(m, k, front.L.data() + k, front.ld, update.data(), ld, 0, m);
      for (int c = 0; c < m; ++c) update.col(c).segment(c, m - c) += F.col(k + c).segment(k + c, m - c);
    }
  }
}

// Into front_, lower triangle: the own columns of H, and what the children leave.
void SelectedInverse::assemble(int s, const std::vector<double>& H, std::vector<MatrixXd>& updates) {
  const Symbolic::Supernode& supernode = symbolic_.supernodes[s];
  const Front& front = fronts_[s];
  Padded F = padded(front_, front.ld, front.n);
  F.setZero();
  for (int column = supernode.first; column < supernode.last; ++column)
    for (int b = pattern_.column_begin[column]; b < pattern_.column_begin[column + 1]; ++b) {
      const int rows = pattern_.dims[pattern_.rows[b]], cols = pattern_.dims[column];
      const double* from = H.data() + pattern_.block_begin[b];
      const int to = row_in_front(s, pattern_.rows[b]), first = pattern_.offsets[column] - front.first_scalar;
      for (int c = 0; c < cols; ++c, from += rows) std::copy_n(from, rows, &F(to, first + c));
    }
  for (int child : front.children) {
    const std::vector<int> to = places_in(front, fronts_[child], 0);
    const int m = static_cast<int>(to.size());
    for (int c = 0; c < m; ++c) {
      const double* const from = &updates[child](0, c);
      double* const column = &F(0, to[c]);
      for (int r = c; r < m; ++r) column[to[r]] += from[r];
    }
    updates[child].resize(0, 0);
  }
}

// By the dense kernels, into the front's L. False where a pivot is so small that it may be none.
bool SelectedInverse::eliminate_at_once(int s) {
  Front& front = fronts_[s];
  const Padded F = padded(front_, front.ld, front.n);
  front.L.resize(front.ld, front.k + 1);
  front.L.leftCols(front.k) = F.leftCols(front.k);
  if (!dense::factor_panel(front.n, front.k, front.L.data(), front.ld)) return false;
  for (int c = 0; c < front.k; ++c)
    if (!(front.L(c, c) * front.L(c, c) > detail::kSuspectPivot * diagonal_[front.first_scalar + c])) return false;
  return true;
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
    VectorXd x = -f.L_below().transpose() * at_below(f, null_);
    f.L_own_transposed().solveInPlace(x);
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

// Z_own and Z_below of a front, those above it done. With V = Wᵀ = L_own⁻ᵀ L_belowᵀ: Z_below = −Z_below,below Vᵀ and
// Z_own = L_own⁻ᵀ L_own⁻¹ − V Z_below. The kernel gives −A Bᵀ.
void SelectedInverse::invert(int s) {
  Front& front = fronts_[s];
  const int k = front.k, m = front.n - front.k, ldk = dense::leading_dimension(k);
  Padded inverse = padded(inverse_, k, k), turned = padded(turned_, ldk, k), own = padded(own_, ldk, k);
  inverse.setIdentity();
  front.L_own().solveInPlace(inverse);
  turned.topRows(k) = -inverse.transpose();
  dense::negative_product(k, k, k, turned.data(), ldk, turned.data(), ldk, own.data(), ldk);
  front.Z.resize(front.ld, k + 1);
  if (m == 0) {  // a root
    front.Z.topLeftCorner(k, k) = -own.topRows(k);
    return;
  }
  const int ldm = dense::leading_dimension(m);
  Padded V = padded(V_, ldk, m), Z_below = padded(Z_below_, ldk, m);
  gather_below(front, ldm);
  dense::negative_product(k, m, k, turned.data(), ldk, front.L.data() + k, front.ld, V.data(), ldk);
  dense::negative_product(m, k, m, below_.data(), ldm, V.data(), ldk, front.Z.data() + k, front.ld);
  Z_below.topRows(k) = front.Z.block(k, 0, m, k).transpose();
  dense::negative_product(k, k, m, V.data(), ldk, Z_below.data(), ldk, turned.data(), ldk);
  for (int c = 0; c < k; ++c)
    for (int r = c; r < k; ++r) front.Z(r, c) = front.Z(c, r) = 0.5 * (turned(r, c) + turned(c, r)) - 0.5 * (own(r, c) + own(c, r));
}

// Into below_: Z where the rows below a front meet, from the fronts above that own them.
void SelectedInverse::gather_below(const Front& front, int ld) {
  const std::size_t m = front.scalars.size();
  Padded Z = padded(below_, ld, static_cast<int>(m));
  const auto front_of = [&](std::size_t row) {
    const auto block =
        std::upper_bound(pattern_.offsets.begin(), pattern_.offsets.end(), front.scalars[row]) - pattern_.offsets.begin() - 1;
    return front_of_[static_cast<std::size_t>(block)];
  };
  for (std::size_t c = 0; c < m;) {
    const Front& above = fronts_[front_of(c)];
    const std::size_t first = c;
    const std::vector<int> places = places_in(above, front, first);
    for (; c < m && front.scalars[c] < above.first_scalar + above.k; ++c) {
      const double* const from = &above.Z(0, places[c - first]);
      for (std::size_t r = c; r < m; ++r) {
        const auto row = static_cast<Eigen::Index>(r), column = static_cast<Eigen::Index>(c);
        Z(row, column) = Z(column, row) = from[places[r - first]];
      }
    }
  }
}

// Block (row, column) of a front that owns `column`, row >= column.
Eigen::Block<const MatrixXd> SelectedInverse::stored(int s, int row, int column) const {
  return fronts_[s].Z.block(row_in_front(s, row), row_in_front(s, column), pattern_.dims[row], pattern_.dims[column]);
}

MatrixXd SelectedInverse::block(int row, int column) const {
  const int first = std::min(row, column), last = std::max(row, column), s = front_of_[first];
  if (row_in_front(s, last) >= 0) return row == last ? MatrixXd(stored(s, last, first)) : MatrixXd(stored(s, last, first).transpose());
  return solve_for(row, column);
}

// The entries of x in the rows below a front's own.
MatrixXd SelectedInverse::at_below(const Front& front, const MatrixXd& x) {
  MatrixXd rows(front.n - front.k, x.cols());
  for (Eigen::Index c = 0; c < x.cols(); ++c)
    for (std::size_t r = 0; r < front.scalars.size(); ++r) rows(static_cast<Eigen::Index>(r), c) = x(front.scalars[r], c);
  return rows;
}

// L Lᵀ x = e of the columns of a block: L y = e changes the fronts from its own to the root alone, and the row's x needs those from the
// root down to its own.
MatrixXd SelectedInverse::solve_for(int row, int column) const {
  MatrixXd x = MatrixXd::Zero(pattern_.scalar_size(), pattern_.dims[column]);
  x.middleRows(pattern_.offsets[column], pattern_.dims[column]).setIdentity();
  for (int s = front_of_[column]; s >= 0; s = fronts_[s].parent) {
    const Front& f = fronts_[s];
    auto own = x.middleRows(f.first_scalar, f.k);
    f.L_own().solveInPlace(own);
    const MatrixXd update = f.L_below() * own;
    for (Eigen::Index c = 0; c < x.cols(); ++c)
      for (std::size_t r = 0; r < f.scalars.size(); ++r) x(f.scalars[r], c) -= update(static_cast<Eigen::Index>(r), c);
  }
  std::vector<int> way;
  for (int s = front_of_[row]; s >= 0; s = fronts_[s].parent) way.push_back(s);
  for (auto s = way.rbegin(); s != way.rend(); ++s) {
    const Front& f = fronts_[*s];
    auto own = x.middleRows(f.first_scalar, f.k);
    own -= f.L_below().transpose() * at_below(f, x);
    f.L_own_transposed().solveInPlace(own);
  }
  return x.middleRows(pattern_.offsets[row], pattern_.dims[row]);
}

}  // namespace holdfast
