#include <algorithm>
#include <cmath>
#include <holdfast/solvers/linear/internal/dense_kernels.hpp>

// Everything here is inlined into one function per vector unit (for_…): a template compiled for AVX2 must never be
// the copy that another translation unit calls on a processor without it.
#define HOLDFAST_INLINE __attribute__((always_inline)) inline

#if defined(__x86_64__) && !defined(HOLDFAST_WITHOUT_AVX2)  // without: a test of what other processors run
#define HOLDFAST_AVX2 __attribute__((target("avx2,fma")))
#endif

namespace holdfast::dense {
namespace {

typedef double Vec __attribute__((vector_size(32), aligned(8)));  // four doubles anywhere; two SSE2 halves without AVX
constexpr int kWidth = 4;
constexpr int kNarrow = 4;  // columns factored before the rest of their block is updated
constexpr int kBlock = 32;  // columns factored before the rest of the panel is updated; a multiple of 4

HOLDFAST_INLINE Vec broadcast(double x) { return Vec{x, x, x, x}; }

// C(4·V × N) −= A(4·V × k) B(N × k)ᵀ, or C = −A Bᵀ where fresh: the tile of C lives in registers.
template <bool Fresh, int V, int N>
HOLDFAST_INLINE void tile(int k, const double* A, int lda, const double* B, int ldb, double* C, int ldc) {
  Vec c[N][V];
  for (int j = 0; j < N; ++j)
    for (int v = 0; v < V; ++v) c[j][v] = Fresh ? broadcast(0) : *reinterpret_cast<const Vec*>(C + j * ldc + kWidth * v);
  for (int p = 0; p < k; ++p) {
    Vec a[V];
    for (int v = 0; v < V; ++v) a[v] = *reinterpret_cast<const Vec*>(A + kWidth * v);
    for (int j = 0; j < N; ++j) {
      const Vec b = broadcast(B[j]);
      for (int v = 0; v < V; ++v) c[j][v] -= a[v] * b;
    }
    A += lda;
    B += ldb;
  }
  for (int j = 0; j < N; ++j)
    for (int v = 0; v < V; ++v) *reinterpret_cast<Vec*>(C + j * ldc + kWidth * v) = c[j][v];
}

// All rows [0, m), m rounded up to fours, of N columns.
template <bool Fresh, int N>
HOLDFAST_INLINE void tile_columns(int m, int k, const double* A, int lda, const double* B, int ldb, double* C, int ldc) {
  int i = 0;
  for (; i + 2 * kWidth < m; i += 3 * kWidth) tile<Fresh, 3, N>(k, A + i, lda, B, ldb, C + i, ldc);
  if (i + kWidth < m)
    tile<Fresh, 2, N>(k, A + i, lda, B, ldb, C + i, ldc);
  else if (i < m)
    tile<Fresh, 1, N>(k, A + i, lda, B, ldb, C + i, ldc);
}

// Columns [first, last) of C −= A Aᵀ (or = −A Aᵀ), from the diagonal down (from the multiple of 4 at or above it).
template <bool Fresh>
HOLDFAST_INLINE void outer(int m, int k, const double* A, int lda, double* C, int ldc, int first, int last) {
  int j = first;
  for (; j + 4 <= last; j += 4) tile_columns<Fresh, 4>(m - j, k, A + j, lda, A + j, lda, C + j + static_cast<long>(j) * ldc, ldc);
  double* c = C + j + static_cast<long>(j) * ldc;
  switch (last - j) {
    case 3:
      return tile_columns<Fresh, 3>(m - j, k, A + j, lda, A + j, lda, c, ldc);
    case 2:
      return tile_columns<Fresh, 2>(m - j, k, A + j, lda, A + j, lda, c, ldc);
    case 1:
      return tile_columns<Fresh, 1>(m - j, k, A + j, lda, A + j, lda, c, ldc);
    default:
      return;
  }
}

// C = −A Bᵀ, all of it.
HOLDFAST_INLINE void product(int m, int n, int k, const double* A, int lda, const double* B, int ldb, double* C, int ldc) {
  int j = 0;
  for (; j + 4 <= n; j += 4) tile_columns<true, 4>(m, k, A, lda, B + j, ldb, C + static_cast<long>(j) * ldc, ldc);
  for (; j < n; ++j) tile_columns<true, 1>(m, k, A, lda, B + j, ldb, C + static_cast<long>(j) * ldc, ldc);
}

// Four times V rows of B ← B L⁻ᵀ, L: b × b, lower.
template <int V>
HOLDFAST_INLINE void solve_tile(int b, const double* L, double* B, int ld, const double* inverse_pivots) {
  for (int j = 0; j < b; ++j) {
    double* column = B + static_cast<long>(j) * ld;
    Vec x[V];
    for (int v = 0; v < V; ++v) x[v] = *reinterpret_cast<const Vec*>(column + kWidth * v);
    for (int p = 0; p < j; ++p) {
      const Vec l = broadcast(L[j + static_cast<long>(p) * ld]);
      for (int v = 0; v < V; ++v) x[v] -= *reinterpret_cast<const Vec*>(B + static_cast<long>(p) * ld + kWidth * v) * l;
    }
    for (int v = 0; v < V; ++v) *reinterpret_cast<Vec*>(column + kWidth * v) = x[v] * broadcast(inverse_pivots[j]);
  }
}

// Rows [b, n) below the factored b × b block at A. Whole fours first: a row of the block itself must not be touched.
HOLDFAST_INLINE void solve_rows(int n, int b, double* A, int ld, const double* inverse_pivots) {
  int i = b;
  for (; i + 4 * kWidth <= n; i += 4 * kWidth) solve_tile<4>(b, A, A + i, ld, inverse_pivots);
  for (; i + kWidth <= n; i += kWidth) solve_tile<1>(b, A, A + i, ld, inverse_pivots);
  for (; i < n; ++i)
    for (int j = 0; j < b; ++j) {
      double x = A[i + static_cast<long>(j) * ld];
      for (int p = 0; p < j; ++p) x -= A[i + static_cast<long>(p) * ld] * A[j + static_cast<long>(p) * ld];
      A[i + static_cast<long>(j) * ld] = x * inverse_pivots[j];
    }
}

HOLDFAST_INLINE bool factor_block(int b, double* A, int ld, double* inverse_pivots) {
  for (int j = 0; j < b; ++j) {
    double* column = A + static_cast<long>(j) * ld;
    for (int p = 0; p < j; ++p) {
      const double* earlier = A + static_cast<long>(p) * ld;
      const double factor = earlier[j];
      for (int i = j; i < b; ++i) column[i] -= factor * earlier[i];
    }
    if (!(column[j] > 0)) return false;
    const double pivot = std::sqrt(column[j]);
    column[j] = pivot;
    inverse_pivots[j] = 1 / pivot;
    for (int i = j + 1; i < b; ++i) column[i] *= inverse_pivots[j];
  }
  return true;
}

// Blocks of kNarrow columns within blocks of kBlock: what cannot be done in vectors stays small, what is updated later is read seldom.
HOLDFAST_INLINE bool panel_of(int n, int k, double* panel, int ld) {
  double inverse_pivots[kNarrow];
  for (int j = 0; j < k; j += kBlock) {
    const int end = std::min(k, j + kBlock);
    for (int i = j; i < end; i += kNarrow) {
      const int b = std::min(kNarrow, end - i);
      double* block = panel + i + static_cast<long>(i) * ld;
      if (!factor_block(b, block, ld, inverse_pivots)) return false;
      solve_rows(n - i, b, block, ld, inverse_pivots);
      if (i + b < end) outer<false>(n - i - b, b, block + b, ld, block + b + static_cast<long>(b) * ld, ld, 0, end - i - b);
    }
    if (end < k)
      outer<false>(n - end, end - j, panel + end + static_cast<long>(j) * ld, ld, panel + end + static_cast<long>(end) * ld, ld, 0,
                   k - end);
  }
  return true;
}

// Four columns at a time: x is read and written once for all four.
HOLDFAST_INLINE void forward_of(int n, int k, const double* panel, int ld, double* x) {
  int j = 0;
  for (; j + 4 <= k; j += 4) {
    const double *c0 = panel + static_cast<long>(j) * ld, *c1 = c0 + ld, *c2 = c1 + ld, *c3 = c2 + ld;
    const double y0 = x[j] / c0[j];
    const double y1 = (x[j + 1] - c0[j + 1] * y0) / c1[j + 1];
    const double y2 = (x[j + 2] - c0[j + 2] * y0 - c1[j + 2] * y1) / c2[j + 2];
    const double y3 = (x[j + 3] - c0[j + 3] * y0 - c1[j + 3] * y1 - c2[j + 3] * y2) / c3[j + 3];
    x[j] = y0, x[j + 1] = y1, x[j + 2] = y2, x[j + 3] = y3;
    for (int i = j + 4; i < n; ++i) x[i] -= c0[i] * y0 + c1[i] * y1 + c2[i] * y2 + c3[i] * y3;
  }
  for (; j < k; ++j) {
    const double* c = panel + static_cast<long>(j) * ld;
    const double y = x[j] /= c[j];
    for (int i = j + 1; i < n; ++i) x[i] -= c[i] * y;
  }
}

// Σ_{i in [first, n)} c[i] x[i], four partial sums at a time.
HOLDFAST_INLINE double dot_from(int first, int n, const double* c, const double* x) {
  Vec sum = broadcast(0);
  int i = first;
  for (; i + kWidth <= n; i += kWidth) sum += *reinterpret_cast<const Vec*>(c + i) * *reinterpret_cast<const Vec*>(x + i);
  double total = (sum[0] + sum[1]) + (sum[2] + sum[3]);
  for (; i < n; ++i) total += c[i] * x[i];
  return total;
}

HOLDFAST_INLINE void backward_of(int n, int k, const double* panel, int ld, double* x) {
  int j = k;
  for (; j >= 4; j -= 4) {
    const double *c3 = panel + static_cast<long>(j - 1) * ld, *c2 = c3 - ld, *c1 = c2 - ld, *c0 = c1 - ld;
    const double s3 = dot_from(j, n, c3, x), s2 = dot_from(j, n, c2, x), s1 = dot_from(j, n, c1, x), s0 = dot_from(j, n, c0, x);
    const double x3 = (x[j - 1] - s3) / c3[j - 1];
    const double x2 = (x[j - 2] - s2 - c2[j - 1] * x3) / c2[j - 2];
    const double x1 = (x[j - 3] - s1 - c1[j - 1] * x3 - c1[j - 2] * x2) / c1[j - 3];
    x[j - 4] = (x[j - 4] - s0 - c0[j - 1] * x3 - c0[j - 2] * x2 - c0[j - 3] * x1) / c0[j - 4];
    x[j - 3] = x1, x[j - 2] = x2, x[j - 1] = x3;
  }
  for (; j > 0; --j) {
    const double* c = panel + static_cast<long>(j - 1) * ld;
    x[j - 1] = (x[j - 1] - dot_from(j, n, c, x)) / c[j - 1];
  }
}

// One set of entry points a vector unit.
#define HOLDFAST_KERNELS(suffix, target)                                                                                      \
  target bool panel_##suffix(int n, int k, double* panel, int ld) { return panel_of(n, k, panel, ld); }                       \
  target void outer_##suffix(int m, int k, const double* A, int lda, double* C, int ldc, int first, int last) {               \
    outer<true>(m, k, A, lda, C, ldc, first, last);                                                                           \
  }                                                                                                                           \
  target void product_##suffix(int m, int n, int k, const double* A, int lda, const double* B, int ldb, double* C, int ldc) { \
    product(m, n, k, A, lda, B, ldb, C, ldc);                                                                                 \
  }                                                                                                                           \
  target void forward_##suffix(int n, int k, const double* panel, int ld, double* x) { forward_of(n, k, panel, ld, x); }      \
  target void backward_##suffix(int n, int k, const double* panel, int ld, double* x) { backward_of(n, k, panel, ld, x); }

HOLDFAST_KERNELS(baseline, )
#ifdef HOLDFAST_AVX2
HOLDFAST_KERNELS(avx2, HOLDFAST_AVX2)
#endif

struct Kernels {
  bool (*panel)(int, int, double*, int) = panel_baseline;
  void (*outer)(int, int, const double*, int, double*, int, int, int) = outer_baseline;
  void (*product)(int, int, int, const double*, int, const double*, int, double*, int) = product_baseline;
  void (*forward)(int, int, const double*, int, double*) = forward_baseline;
  void (*backward)(int, int, const double*, int, double*) = backward_baseline;

  Kernels() {
#ifdef HOLDFAST_AVX2
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
      panel = panel_avx2;
      outer = outer_avx2;
      product = product_avx2;
      forward = forward_avx2;
      backward = backward_avx2;
    }
#endif
  }
};
const Kernels kernels;

}  // namespace

bool factor_panel(int n, int k, double* panel, int ld) { return kernels.panel(n, k, panel, ld); }

void negative_outer(int m, int k, const double* A, int lda, double* C, int ldc, int first, int last) {
  kernels.outer(m, k, A, lda, C, ldc, first, last);
}

void negative_product(int m, int n, int k, const double* A, int lda, const double* B, int ldb, double* C, int ldc) {
  kernels.product(m, n, k, A, lda, B, ldb, C, ldc);
}

void forward(int n, int k, const double* panel, int ld, double* x) { kernels.forward(n, k, panel, ld, x); }
void backward(int n, int k, const double* panel, int ld, double* x) { kernels.backward(n, k, panel, ld, x); }

int leading_dimension(int n) {
  const int ld = (n + kWidth - 1) / kWidth * kWidth;
  return ld % 512 == 0 ? ld + 8 : ld;  // columns 4 KiB apart fall into the same cache set
}

}  // namespace holdfast::dense
