// Variables leave a graph and what is known through them stays: their factors are replaced by LinearPriors on their neighbours.
//
//   marginalize(graph, values, {A(0), A(1)});     // A0 and A1 are gone from the graph and the values
//
// One variable at a time: its factors, linearised at the values, robust ones at their current weight w ρ'(s), are stacked as
// [J_a J_b r] and brought to triangular form by Householder reflections,
//     [R_a  S  d]        R_a: what is eliminated
//     [ 0   A  b]   →    the prior r = A δ + b on the neighbours  (AᵀA is the Schur complement of the normal equations)
//     [ 0   0  c]        c²/2: the cost that no value of the neighbours changes
// This is the square-root form: numbers keep their digits where AᵀA would lose half of them. A direction without information (a column
// that is rounding, 1e-14 of what it was) gets no row: of a variable that is not observable nothing is invented.
// For linear factors with the loss Squared nothing is lost: the neighbours' estimate and covariance are those of the full problem, and
// min over the variable of the old cost = the new cost + constant. Else it is exact to first order at the values: solve before.
// A fixed variable is a constant of its factors.
#pragma once

#include <holdfast/graph/graph.hpp>

namespace holdfast {

/// Removes the keys from graph and values. Throws BadKey (a key without value, before anything is changed), BadType, and BadNumber where
/// a residual or Jacobian is not finite, naming the factor; that key and those after it in the list are then still there.
void marginalize(Graph& graph, Values& values, const std::vector<Key>& keys);

/// The same, keeping its memory from call to call, one key at a time.
class Marginalizer {
 public:
  /// Replaces the factors on `key` by one LinearPrior on their other variables; the value of `key` stays for the caller to erase.
  /// Returns the prior, number −1 where nothing is left to say. Throws BadNumber; the graph is then as it was.
  FactorId eliminate(Graph& graph, const Values& values, Key key);
  /// Removes the factors on `key` and leaves nothing (paper A's window).
  void drop(Graph& graph, Key key);

 private:
  struct Neighbour {
    Key key;
    Values::Slot slot;
    int column;  ///< −1: fixed
  };
  void find_factors(const Graph& graph, Key key);
  void find_neighbours(const Graph& graph, const Values& values, Key key);
  void stack(const Graph& graph, const Values& values);
  void stack_factor(const FactorBatch& batch, int i, const Values& values, int row);
  int triangulate(int first_row, int begin, int end);
  void write_prior(const Values& values, int first_row, int rank);
  int column_of(Key key) const;

  std::vector<FactorId> factors_;
  std::vector<Neighbour> neighbours_;  ///< the variable itself first
  int rows_ = 0, columns_ = 0;         ///< of the stack, without r
  std::vector<double> stack_;          ///< rows × (columns + 1), column-major
  std::vector<double> scale_;          ///< of each column: its norm at first
  std::vector<double> r_, J_, weights_;
  std::vector<const double*> ambient_;
  double constant_ = 0;
  LinearPrior prior_;
};

}  // namespace holdfast
