// The blocks of H⁻¹ wherever the Cholesky factor of H has some (Takahashi et al. 1973, by dense fronts), in memory O(factor). Internal.
//
// Fronts are factored from the leaves up, H = L Lᵀ; then, from the root down, with W = L_below,own L_own,own⁻¹ of each front,
//
//   Z_below,own = −Z_below,below W        Z_own,own = L_own,own⁻ᵀ L_own,own⁻¹ − Wᵀ Z_below,own        Z = H⁻¹
//
// where Z_below,below is among the blocks of the fronts above. A singular H is factored, too: a pivot that vanishes is replaced by a
// positive number, which adds to H a matrix D with rank D = dim ker H, so that (H + D)⁻¹ is a generalised inverse: its block of a
// variable that no null vector of H moves is the covariance of that variable. Which ones are moved is noted on the way.
#pragma once

#include <Eigen/Core>
#include <holdfast/solvers/linear/internal/normal_equations.hpp>
#include <holdfast/solvers/linear/internal/symbolic.hpp>

namespace holdfast {

class SelectedInverse {
 public:
  /// H: lower triangle, values of `pattern`, which is in symbolic.order; positive semidefinite.
  SelectedInverse(Symbolic symbolic, const BlockPattern& pattern, const std::vector<double>& H);

  /// Some null vector of H moves this block.
  bool is_free(int block) const { return free_[block]; }
  /// dims[row] × dims[column] of the (generalised) inverse. O(block) where the factor has that block, else O(factor · dims[column]).
  Eigen::MatrixXd block(int row, int column) const;

 private:
  struct Front {
    int first_scalar, k, n;
    int first_descendant;  ///< fronts [first_descendant, this] are its subtree
    std::vector<int> children;
    std::vector<int> row_begin;  ///< of each block of Supernode::rows, in the front
    Eigen::MatrixXd L, Z;        ///< n × k
  };

  void make_fronts();
  void factor(const std::vector<double>& H);
  Eigen::MatrixXd assemble(int s, const std::vector<double>& H, std::vector<Eigen::MatrixXd>& updates);
  void eliminate(int s, Eigen::MatrixXd& F);
  bool pivot_vanishes(int s, const Eigen::MatrixXd& F, int column);
  double extend_to_null_vector(int s, const Eigen::MatrixXd& F, int column);
  void note_free(int begin, int pivot);
  void invert(int s);
  int row_in_front(int s, int block) const;
  Eigen::Block<const Eigen::MatrixXd> stored(int s, int row, int column) const;
  Eigen::VectorXd below(const Front& front, const Symbolic::Supernode& supernode, const Eigen::VectorXd& x) const;
  void solve_in_place(Eigen::VectorXd& x) const;

  Symbolic symbolic_;
  BlockPattern pattern_;
  std::vector<Front> fronts_;
  std::vector<int> front_of_;  ///< by block
  std::vector<bool> free_;     ///< by block
  Eigen::VectorXd diagonal_;   ///< of H
  Eigen::VectorXd null_;       ///< a null vector at work; zero between uses
};

}  // namespace holdfast
