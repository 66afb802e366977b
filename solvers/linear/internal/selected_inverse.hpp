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
  /// dims[row] × dims[column] of the (generalised) inverse. O(block) where the factor has that block, else a solve for each of
  /// dims[column] along the ways from both blocks' fronts to the root.
  Eigen::MatrixXd block(int row, int column) const;

 private:
  struct Front {
    int first_scalar, k, n;
    int ld;  ///< of L and Z (dense_kernels.hpp)
    int parent;
    int first_descendant;  ///< fronts [first_descendant, this] are its subtree
    std::vector<int> children;
    std::vector<int> row_begin;  ///< of each block of Supernode::rows, in the front
    std::vector<int> scalars;    ///< of each row below the own ones, in the problem
    Eigen::MatrixXd L, Z;        ///< n × k; in ld × (k + 1), for the kernels read and write a little more

    auto L_own() const { return L.topLeftCorner(k, k).triangularView<Eigen::Lower>(); }
    auto L_own_transposed() const { return L.topLeftCorner(k, k).transpose().triangularView<Eigen::Upper>(); }
    auto L_below() const { return L.block(k, 0, n - k, k); }
  };

  void make_fronts();
  void factor(const std::vector<double>& H);
  void assemble(int s, const std::vector<double>& H, std::vector<Eigen::MatrixXd>& updates);
  bool eliminate_at_once(int s);
  void eliminate(int s, Eigen::MatrixXd& F);
  bool pivot_vanishes(int s, const Eigen::MatrixXd& F, int column);
  double extend_to_null_vector(int s, const Eigen::MatrixXd& F, int column);
  void note_free(int begin, int pivot);
  void invert(int s);
  void gather_below(const Front& front, int ld);
  std::vector<int> places_in(const Front& above, const Front& front, std::size_t from) const;
  int row_in_front(int s, int block) const;
  Eigen::Block<const Eigen::MatrixXd> stored(int s, int row, int column) const;
  static Eigen::MatrixXd at_below(const Front& front, const Eigen::MatrixXd& x);
  Eigen::MatrixXd solve_for(int row, int column) const;

  Symbolic symbolic_;
  BlockPattern pattern_;
  std::vector<Front> fronts_;
  std::vector<int> front_of_;                                                 ///< by block
  std::vector<bool> free_;                                                    ///< by block
  Eigen::VectorXd diagonal_;                                                  ///< of H
  Eigen::VectorXd null_;                                                      ///< a null vector at work; zero between uses
  std::vector<double> front_, inverse_, turned_, V_, below_, Z_below_, own_;  ///< of the front at hand, at least as large as it
};

}  // namespace holdfast
