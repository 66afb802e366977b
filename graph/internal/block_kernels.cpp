#include <algorithm>
#include <holdfast/graph/internal/block_kernels.hpp>
#include <holdfast/graph/internal/scratch.hpp>

namespace holdfast {
namespace {

/// Sizes known to the compiler.
template <int Rows, int... D>
class Fixed {
 public:
  static constexpr int M = Rows;
  static constexpr int K = sizeof...(D);
  static constexpr int N = (0 + ... + D);
  static constexpr std::array<int, K> dims{D...};

  explicit Fixed(const FactorBatch&) {}
  static constexpr int m() { return M; }
  static constexpr int n() { return N; }
  double* rows() { return rows_; }
  double* gradient() { return gradient_; }
  double* hessian() { return hessian_; }
  double* weighted() { return weighted_; }

  /// The blocks of Jᵀ diag(hessian) J.
  double* blocks(double* out) { return column<0, 0, 0, 0>(out); }

 private:
  template <int A, int B, int FirstA, int FirstB>
  double* column(double* out) {
    if constexpr (B == K) {
      return out;
    } else if constexpr (A == K) {
      return column<B + 1, B + 1, FirstB + dims[B], FirstB + dims[B]>(out);
    } else {
      constexpr int R = dims[A], C = dims[B];
      for (int c = 0; c < C; ++c) {
        double sum[R] = {};
        for (int m = 0; m < M; ++m) {
          const double scaled = hessian_[m] * rows_[m * N + FirstB + c];
          for (int k = 0; k < R; ++k) sum[k] += rows_[m * N + FirstA + k] * scaled;
        }
        std::copy_n(sum, R, out + c * R);
      }
      return column<A + 1, B, FirstA + R, FirstB>(out + R * C);
    }
  }

  double rows_[M * N], gradient_[M], hessian_[M], weighted_[std::max(M, N)];
};

/// Sizes known to the batch.
class Any {
 public:
  static constexpr int M = Eigen::Dynamic;

  explicit Any(const FactorBatch& batch) : dims_(batch.dims()), m_(batch.residual_dim()), n_(batch.total_dim()) {
    const std::size_t m = m_, n = n_;
    rows_ = scratch<Any>(m * n + 2 * m + std::max(m, n));
  }
  int m() const { return m_; }
  int n() const { return n_; }
  double* rows() { return rows_; }
  double* gradient() { return rows_ + static_cast<std::ptrdiff_t>(m_) * n_; }
  double* hessian() { return gradient() + m_; }
  double* weighted() { return hessian() + m_; }

  double* blocks(double* out) {
    int first_b = 0;
    for (std::size_t b = 0; b < dims_.size(); first_b += dims_[b++]) {
      int first_a = first_b;
      for (std::size_t a = b; a < dims_.size(); first_a += dims_[a++]) out = block(first_a, dims_[a], first_b, dims_[b], out);
    }
    return out;
  }

 private:
  double* block(int first_a, int rows, int first_b, int columns, double* out) {
    std::fill(out, out + static_cast<std::ptrdiff_t>(rows) * columns, 0.0);
    for (int c = 0; c < columns; ++c, out += rows)
      for (int m = 0; m < m_; ++m) {
        const double* row = rows_ + static_cast<std::ptrdiff_t>(m) * n_;
        const double scaled = hessian()[m] * row[first_b + c];
        if (scaled == 0) continue;
        for (int k = 0; k < rows; ++k) out[k] += row[first_a + k] * scaled;
      }
    return out;
  }

  const std::vector<int>& dims_;
  int m_, n_;
  double* rows_;
};

/// y = Σ_m rows[m] x[m], summed row by row.
template <class Size>
void add_rows(Size& size, const double* x, double* y) {
  std::fill(y, y + size.n(), 0.0);
  for (int m = 0; m < size.m(); ++m)
    for (int n = 0; n < size.n(); ++n) y[n] += size.rows()[m * size.n() + n] * x[m];
}

template <class Size>
void contributions(const FactorBatch& batch, const double* r, const double* J, int first, int last, Curvature curvature, double* out) {
  Size size(batch);
  const int M = size.m(), N = size.n();
  for (int i = first; i < last; ++i, r += M, J += M * N) {
    const TermWeight w = row_weights<Size::M>(batch.loss(i), batch.weight(i), r, M, curvature, size.gradient(), size.hessian());
    for (int m = 0; m < M; ++m)  // J row by row: what is summed up below is then contiguous
      for (int n = 0; n < N; ++n) size.rows()[m * N + n] = J[n * M + m];
    double* const blocks = out;
    out = size.blocks(out);
    if (w.rank_one != 0) {
      double* const v = out;  // Jᵀ r, where the gradient will be
      add_rows(size, r, v);
      double* block = blocks;
      int first_b = 0;
      for (const int& columns : batch.dims()) {
        int first_a = first_b;
        for (const int* rows = &columns; rows != batch.dims().data() + batch.dims().size(); first_a += *rows++)
          for (int c = 0; c < columns; ++c)
            for (int k = 0; k < *rows; ++k) *block++ += w.rank_one * v[first_a + k] * v[first_b + c];
        first_b += columns;
      }
    }
    for (int m = 0; m < M; ++m) size.weighted()[m] = size.gradient()[m] * r[m];
    add_rows(size, size.weighted(), out);
    out[N] = w.cost;
    out += N + 1;
  }
}

template <class Size>
void multiply_transposed(const FactorBatch& batch, const double* J, const double* x, double* y) {
  const Size size(batch);
  for (int n = 0; n < size.n(); ++n, J += size.m()) {
    if constexpr (Size::M != Eigen::Dynamic) {
      y[n] = Eigen::Map<const Vector<Size::M>>(J).dot(Eigen::Map<const Vector<Size::M>>(x));
    } else {
      y[n] = 0;
      for (int m = 0; m < size.m(); ++m) y[n] += J[m] * x[m];
    }
  }
}

template <class Size>
void gradients(const FactorBatch& batch, const double* r, const double* J, int first, int last, int stride, double* out) {
  Size size(batch);
  const int M = size.m(), N = size.n();
  for (int i = first; i < last; ++i, r += M, J += M * N, out += stride) {
    const TermWeight w = row_weights<Size::M>(batch.loss(i), batch.weight(i), r, M, Curvature::irls, size.gradient(), size.hessian());
    for (int m = 0; m < M; ++m) size.weighted()[m] = size.gradient()[m] * r[m];
    multiply_transposed<Size>(batch, J, size.weighted(), out);
    out[N] = w.cost;
  }
}

template <class Size>
void multiply(const FactorBatch& batch, const double* J, const double* x, double* y) {
  const Size size(batch);
  std::fill(y, y + size.m(), 0.0);
  for (int n = 0; n < size.n(); ++n)
    for (int m = 0; m < size.m(); ++m) y[m] += J[n * size.m() + m] * x[n];
}

template <class Size>
constexpr BlockKernels kernels_of{contributions<Size>, gradients<Size>, multiply<Size>, multiply_transposed<Size>};

struct Usual {
  int residual_dim;
  std::vector<int> dims;
  const BlockKernels* kernels;
};
template <int Rows, int... D>
Usual usual() {
  return {Rows, {D...}, &kernels_of<Fixed<Rows, D...>>};
}

}  // namespace

const BlockKernels& block_kernels(int residual_dim, const std::vector<int>& dims) {
  static const Usual all[]{
      usual<1, 1>(),    usual<2, 2>(),    usual<3, 3>(),    usual<4, 4>(),    usual<6, 6>(),    usual<9, 9>(),  // priors
      usual<1, 2, 2>(), usual<1, 3, 3>(), usual<1, 3, 2>(), usual<1, 6, 3>(), usual<1, 6, 6>(), usual<1, 4, 2>(),
      usual<1, 4, 4>(), usual<1, 2>(),    usual<1, 3>(),    usual<1, 4>(),    usual<1, 6>(),                    // ranges
      usual<2, 3, 2>(), usual<2, 4, 2>(), usual<3, 6, 3>(), usual<2, 2, 2>(), usual<2, 4>(),    usual<3, 6>(),  // positions, bearings
      usual<3, 3, 3>(), usual<6, 6, 6>(), usual<4, 4, 4>(), usual<9, 9, 9>(),                                   // steps
      usual<5, 5>(),    usual<2, 5>(),    usual<5, 5, 5>()};                                                    // Turning2
  for (const Usual& one : all)
    if (one.residual_dim == residual_dim && one.dims == dims) return *one.kernels;
  return kernels_of<Any>;
}

double* write_blocks(const std::vector<int>& dims, const double* H, double scale, double rank_one, const double* v, double* out) {
  int n = 0;
  for (const int d : dims) n += d;
  int first_b = 0;
  for (std::size_t b = 0; b < dims.size(); first_b += dims[b++]) {
    int first_a = first_b;
    for (std::size_t a = b; a < dims.size(); first_a += dims[a++])
      for (int c = first_b; c < first_b + dims[b]; ++c)
        for (int k = first_a; k < first_a + dims[a]; ++k) {
          *out = scale * H[static_cast<std::ptrdiff_t>(c) * n + k];
          if (rank_one != 0) *out += rank_one * v[k] * v[c];
          ++out;
        }
  }
  return out;
}

}  // namespace holdfast
