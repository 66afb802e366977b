#include <algorithm>
#include <cmath>
#include <holdfast/solvers/dense_kernels.hpp>

// Everything here is inlined into one function per vector unit (for_…): a template compiled for AVX2 must never be
// the copy that another translation unit calls on a processor without it.
#define HOLDFAST_INLINE __attribute__((always_inline)) inline

#if defined(__x86_64__)
#define HOLDFAST_AVX2 __attribute__((target("avx2,fma")))
#endif

namespace holdfast::dense {
namespace {

typedef double Vec __attribute__((vector_size(32), aligned(8)));  // four doubles anywhere; two SSE2 halves without AVX
constexpr int kWidth = 4;
constexpr int kBlock = 32;  // columns factored before the rest of the panel is updated; a multiple of 4

HOLDFAST_INLINE Vec broadcast(double x) { return Vec{x, x, x, x}; }

// C(4·V × N) −= A(4·V × k) B(N × k)ᵀ: the tile of C lives in registers.
template <int V, int N>
HOLDFAST_INLINE void tile(int k, const double* A, int lda, const double* B, int ldb, double* C, int ldc) {
  Vec c[N][V];
  for (int j = 0; j < N; ++j)
    for (int v = 0; v < V; ++v) c[j][v] = *reinterpret_cast<const Vec*>(C + j * ldc + kWidth * v);
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
template <int N>
HOLDFAST_INLINE void tile_columns(int m, int k, const double* A, int lda, const double* B, int ldb, double* C, int ldc) {
  int i = 0;
  for (; i + 2 * kWidth < m; i += 3 * kWidth) tile<3, N>(k, A + i, lda, B, ldb, C + i, ldc);
  if (i + kWidth < m)
    tile<2, N>(k, A + i, lda, B, ldb, C + i, ldc);
  else if (i < m)
    tile<1, N>(k, A + i, lda, B, ldb, C + i, ldc);
}

// Columns [first, last) of C −= A Aᵀ, from the diagonal down (from the multiple of 4 at or above it).
HOLDFAST_INLINE void outer(int m, int k, const double* A, int lda, double* C, int ldc, int first, int last) {
  int j = first;
  for (; j + 4 <= last; j += 4) tile_columns<4>(m - j, k, A + j, lda, A + j, lda, C + j + static_cast<long>(j) * ldc, ldc);
  double* c = C + j + static_cast<long>(j) * ldc;
  switch (last - j) {
    case 3:
      return tile_columns<3>(m - j, k, A + j, lda, A + j, lda, c, ldc);
    case 2:
      return tile_columns<2>(m - j, k, A + j, lda, A + j, lda, c, ldc);
    case 1:
      return tile_columns<1>(m - j, k, A + j, lda, A + j, lda, c, ldc);
    default:
      return;
  }
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

HOLDFAST_INLINE bool panel_of(int n, int k, double* panel, int ld) {
  double inverse_pivots[kBlock];
  for (int j = 0; j < k; j += kBlock) {
    const int b = std::min(kBlock, k - j);
    double* block = panel + j + static_cast<long>(j) * ld;
    if (!factor_block(b, block, ld, inverse_pivots)) return false;
    solve_rows(n - j, b, block, ld, inverse_pivots);
    if (j + b < k) outer(n - j - b, b, block + b, ld, block + b + static_cast<long>(b) * ld, ld, 0, k - j - b);
  }
  return true;
}

bool panel_baseline(int n, int k, double* panel, int ld) { return panel_of(n, k, panel, ld); }
void outer_baseline(int m, int k, const double* A, int lda, double* C, int ldc, int first, int last) { outer(m, k, A, lda, C, ldc, first, last); }

#ifdef HOLDFAST_AVX2
HOLDFAST_AVX2 bool panel_avx2(int n, int k, double* panel, int ld) { return panel_of(n, k, panel, ld); }
HOLDFAST_AVX2 void outer_avx2(int m, int k, const double* A, int lda, double* C, int ldc, int first, int last) {
  outer(m, k, A, lda, C, ldc, first, last);
}
#endif

struct Kernels {
  bool (*panel)(int, int, double*, int) = panel_baseline;
  void (*outer)(int, int, const double*, int, double*, int, int, int) = outer_baseline;

  Kernels() {
#ifdef HOLDFAST_AVX2
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
      panel = panel_avx2;
      outer = outer_avx2;
    }
#endif
  }
};
const Kernels kernels;

}  // namespace

bool factor_panel(int n, int k, double* panel, int ld) { return kernels.panel(n, k, panel, ld); }

void subtract_outer(int m, int k, const double* A, int lda, double* C, int ldc) { kernels.outer(m, k, A, lda, C, ldc, 0, m); }

void subtract_outer_columns(int m, int k, const double* A, int lda, double* C, int ldc, int first, int last) {
  kernels.outer(m, k, A, lda, C, ldc, first, last);
}

int leading_dimension(int n) {
  const int ld = (n + kWidth - 1) / kWidth * kWidth;
  return ld % 512 == 0 ? ld + 8 : ld;  // columns 4 KiB apart fall into the same cache set
}

}  // namespace holdfast::dense
