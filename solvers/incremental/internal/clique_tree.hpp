// A sparse Cholesky factorisation that is changed in place: Σ H_t over terms t on a few variables each, that come, go and change. Internal.
//
// The factor is a tree of cliques, as in iSAM2's Bayes tree (Kaess et al. 2012): a clique eliminates its own variables, in one dense front,
// and hands its parent an update on the others (its separator). Each clique keeps that update. So when terms change, only the cliques of
// their variables and those above them, up to the root, are made again; whole subtrees below hang on as they are, with what they handed up.
// Variables of the latest terms are eliminated last, near the root, where the next change will most likely be.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace holdfast::io {
class ByteReader;
class ByteWriter;
}  // namespace holdfast::io

namespace holdfast::detail {

class CliqueTree {
 public:
  /// Variables and terms have numbers; numbers of those that are gone are given out again.
  int add_variable(int dim);
  /// Of a variable that no term ties any more.
  void remove_variable(int variable);

  /// A term ½ δᵀHδ + gᵀδ on these variables, in this order: H is n × n, column-major, both triangles.
  int add_term(const std::vector<int>& variables, const std::vector<double>& H, const std::vector<double>& g);
  void change_term(int term, const std::vector<double>& H, const std::vector<double>& g);
  void remove_term(int term);
  const std::vector<int>& terms_on(int variable) const { return variables_[variable].terms; }
  const std::vector<int>& variables_of(int term) const { return terms_[term].variables; }

  /// Makes the cliques again that changed terms touch, and solves Σ H δ = −Σ g. Returns −1, or a variable whose pivot is not positive:
  /// what was to be made again is then made again by the next call. Parts of δ that have changed by less than `tolerance` (of any
  /// component) since they were last followed down the tree are not followed.
  int update(double tolerance);
  /// Orders everything anew.
  int reorder(double tolerance);

  /// Of the last update().
  const double* delta(int variable) const { return &delta_[variables_[variable].offset]; }
  /// δ of this variable is 0 from now on: it was linearised anew where it is. Its terms have to be changed, too.
  void restart(int variable);
  /// δᵀ H_vv δ of this variable's δ, of all terms on it: the square of how far it moved in sigmas, had all others stood still.
  double moved(int variable) const;
  const std::vector<int>& changed() const { return changed_; }  ///< the variables whose δ it changed
  int remade() const { return remade_; }                        ///< how many variables it eliminated again
  double work() const { return work_; }                         ///< multiply–add pairs of it
  /// Covariance of these variables together, from the factor: Σ_ab of all pairs, in their order, column-major. Cost: a solve a scalar.
  Eigen::MatrixXd covariance(const std::vector<int>& variables);

  void write(io::ByteWriter& out) const;
  /// What comes next has the same bits as of the tree that was written. Throws BadFile.
  static CliqueTree read(io::ByteReader& in);

  bool is_empty() const;
  int variables() const { return static_cast<int>(variables_.size()); }  ///< numbers given out, also of those that are gone
  int terms() const { return static_cast<int>(terms_.size()); }
  int dim(int variable) const { return variables_[variable].dim; }

 private:
  struct Variable {
    int dim = 0;
    std::size_t offset = 0;  // in delta_
    int clique = -1;
    std::vector<int> terms;
    bool is_late = false;  // to be eliminated last
    int local = -1;        // number while being made again
  };
  struct Term {
    std::vector<int> variables;
    std::vector<double> H, g;
    int assembled = -1;  // the last update that assembled it
  };
  struct Clique {
    std::vector<int> own, separator;  // variables
    int parent = -1;
    std::vector<int> children;
    int k = 0, n = 0, ld = 0;   // scalars: own, all; leading dimension of the panel
    std::vector<double> panel;  // n × k
    std::vector<double> y;      // n: L⁻¹ b of the own part, then what is handed up of b
    int update_ld = 0;
    std::vector<double> update;  // m × m, lower: what is handed up
  };

  void touch(int variable);
  void take_off(int clique);
  struct Columns;
  int eliminate_dirty();
  void find_structure(Columns& columns);
  void join_columns(Columns& columns) const;
  int make_cliques(Columns& columns);
  void take_back(const Columns& columns);
  std::vector<int> order_of(const std::vector<int>& variables, const std::vector<int>& orphans);
  int make_clique(const std::vector<int>& own, const std::vector<int>& separator, const std::vector<int>& children);
  bool make_front(int number);
  void lay_out(Clique& clique);
  void assemble_own(Clique& clique);
  int weakest(Clique& clique);
  void find_terms(const Clique& clique);
  enum class Part { own, separator };  ///< columns of a front
  static double* column_of(Clique& clique, int column);
  void add_term_to(Clique& clique, const Term& term, Part part);
  void add_update_to(Clique& clique, const Clique& child, Part part);
  void solve_down(double tolerance);
  void solve_clique(Clique& clique, std::vector<double>& x) const;
  int new_clique();
  void require_sound();
  void make_fronts();

  std::vector<Variable> variables_;
  std::vector<Term> terms_;
  std::vector<Clique> cliques_;
  std::vector<std::vector<int>> free_variables_;  // by dimension: their places in delta_ serve again
  std::vector<int> free_terms_, free_cliques_;
  std::vector<double> delta_, told_;  // told: δ when it was last followed down
  std::vector<int> dirty_;            // variables without a clique
  std::vector<int> orphans_;          // cliques without a parent, to be hung on again
  std::vector<int> roots_;
  std::vector<int> fresh_;  // cliques made by the update at hand
  std::vector<int> late_;   // variables with is_late
  std::vector<int> changed_;
  std::vector<int> scalar_of_, in_front_;  // of each variable in the front at hand; the number of the front
  std::vector<int> front_terms_, to_;
  std::vector<double> diagonal_;
  int front_ = 0, culprit_ = -1;
  std::vector<char> moved_;  // of each variable: δ changed in the solve at hand
  int updates_ = 0, remade_ = 0;
  double work_ = 0;
};

}  // namespace holdfast::detail
