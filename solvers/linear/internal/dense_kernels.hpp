// The dense inner loops of the sparse Cholesky factorisation. Column-major, lower triangles. The processor's vector unit is
// looked up at run time, so that one build runs everywhere and fast where it can.
//
// Rows are worked on four at a time: every column must be readable and writable up to the next multiple of 4 rows (leading
// dimension a multiple of 4); what stands in the rows beyond the last, and above the diagonal, is undefined afterwards.
#pragma once

namespace holdfast::dense {

/// Factors the first k columns of the symmetric n × n matrix whose first k columns are in `panel` (leading dimension ld ≥ n):
/// panel becomes [L11; L21]. False where a pivot is not positive (a NaN is not).
bool factor_panel(int n, int k, double* panel, int ld);

/// Columns [first, last) of C = −A Aᵀ, lower triangle; A: m × k, k ≥ 1; first a multiple of 4.
void negative_outer(int m, int k, const double* A, int lda, double* C, int ldc, int first, int last);

/// C = −A Bᵀ; A: m × k, B: n × k, C: m × n, k ≥ 1.
void negative_product(int m, int n, int k, const double* A, int lda, const double* B, int ldb, double* C, int ldc);

/// x[0, k) ← L11⁻¹ x[0, k), then x[k, n) −= L21 x[0, k).
void forward(int n, int k, const double* panel, int ld, double* x);

/// x[0, k) ← L11⁻ᵀ (x[0, k) − L21ᵀ x[k, n)).
void backward(int n, int k, const double* panel, int ld, double* x);

/// A leading dimension for n rows: a multiple of 4 that keeps columns apart in the cache.
int leading_dimension(int n);

}  // namespace holdfast::dense
