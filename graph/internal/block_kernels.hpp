// What is made of the residuals and Jacobians of a batch's factors. It depends on sizes only (rows, dimension of each variable), not on the
// factor type: the usual sizes have code of their own, compiled once in the library; any others share one that reads them at run time.
#pragma once

#include <holdfast/graph/batch.hpp>

namespace holdfast {

/// r, J: of factors [first, last), as FactorBatch::evaluate writes them.
struct BlockKernels {
  /// As FactorBatch::contributions_at.
  void (*contributions)(const FactorBatch& batch, const double* r, const double* J, int first, int last, Curvature curvature, double* out);
  /// As FactorBatch::gradients; factor i's go to out + (i − first) · stride.
  void (*gradients)(const FactorBatch& batch, const double* r, const double* J, int first, int last, int stride, double* out);
  /// y = J x of one factor.
  void (*multiply)(const FactorBatch& batch, const double* J, const double* x, double* y);
  /// y = Jᵀ x of one factor.
  void (*multiply_transposed)(const FactorBatch& batch, const double* J, const double* x, double* y);
};

const BlockKernels& block_kernels(int residual_dim, const std::vector<int>& dims);

/// The blocks (a, b), a ≥ b, of scale · H + rank_one v vᵀ, H a symmetric N × N matrix; returns where they end.
double* write_blocks(const std::vector<int>& dims, const double* H, double scale, double rank_one, const double* v, double* out);

}  // namespace holdfast
