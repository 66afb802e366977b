// LDLᵀ of a symmetric matrix with a thin envelope: every row is stored from its first entry to its diagonal, and stays so when factored
// (George & Liu 1981, ch. 4). For chains and windows in a good order there is no less work to do, and none of the bookkeeping of fronts.
// Keeps its memory from one layout to the next. Internal.
#pragma once

#include <vector>

namespace holdfast {

class EnvelopeCholesky {
 public:
  /// first[i] ≤ i: the column where row i begins.
  void set_layout(const std::vector<int>& first);

  int size() const { return static_cast<int>(first_.size()); }
  /// Where entry (row, column) lies in matrix(); first[row] ≤ column ≤ row.
  int place(int row, int column) const { return origin_[row] + column; }
  std::vector<double>& matrix() { return matrix_; }
  double diagonal(int row) const { return matrix_[place(row, row)]; }

  /// Factors matrix() + diag(damping); false where it is not positive definite (matrix() stays as it is).
  bool factor(const std::vector<double>& damping);
  /// x: right-hand side in, solution out.
  void solve(std::vector<double>& x) const;

 private:
  std::vector<int> first_, origin_;
  std::vector<double> matrix_;
  std::vector<double> lower_;             // L, unit diagonal left out, in the places of matrix()
  std::vector<double> inverse_diagonal_;  // of D
};

}  // namespace holdfast
