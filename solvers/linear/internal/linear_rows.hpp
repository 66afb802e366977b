// A problem whose factors are all linear, as sparse scalar rows r = r⁰ + J t, and its normal equations in an envelope. What a window costs
// is mostly overhead of blocks and fronts; here structural zeros go (axes that do not meet separate by themselves), unknowns are ordered by
// breadth-first search, and an iteration is a few passes over some hundred numbers. Keeps its memory when the structure changes. Internal.
#pragma once

#include <holdfast/graph/resolved.hpp>
#include <holdfast/solvers/irls/internal/line_search.hpp>
#include <holdfast/solvers/linear/internal/envelope_cholesky.hpp>

namespace holdfast::detail {

class LinearRows {
 public:
  /// Evaluates residuals and Jacobians at the values. False where the envelope would be wide: such problems are for fronts.
  bool load(const Graph& graph, const Values& values);

  const Resolved& resolved() const { return resolved_; }
  /// Fills H and g, returns the cost.
  double linearize(const Graph& graph, Curvature curvature);
  const std::vector<double>& gradient() const { return gradient_; }
  /// (H + λ diag H) δ = −g; returns the decrease of the cost that the model predicts, NaN where the matrix is not positive definite.
  double solve_damped(double lambda);
  void apply_step(const Graph&);  ///< J δ
  double slope() const { return dot(gradient_, step_); }
  Phi phi(const Graph& graph, double alpha) const;
  void move_along(double alpha);
  /// values ⊕ the whole way.
  void retract(Values& values);

 private:
  struct Part {  // of one batch
    int first_row, rows, first_jacobian, first_extra;
  };
  static bool weighs_whole_blocks(const FactorBatch& batch);
  static bool has_code_for(const std::unique_ptr<FactorBatch>& batch);
  bool losses_are_as_before(const Graph& graph);
  void evaluate(const Graph& graph, const Values& values);
  bool pattern_holds() const;
  void find_pattern(const Graph& graph);
  template <class Visit>
  void for_each_column(const FactorBatch& batch, std::size_t b, int factor, const Visit& visit) const;
  void add_row(const FactorBatch& batch, std::size_t b, int factor, int row);
  void add_union_of_rows(const FactorBatch& batch, std::size_t b, int factor);
  void order_unknowns();
  void visit(int start);
  bool lay_out_matrix();  ///< false: not thin
  void lay_out_products();
  void weigh(const FactorBatch& batch, const Part& part, Curvature curvature, double& cost);
  double weigh_huber(const Part& part, double a, Curvature curvature);
  template <int M>
  void weigh_blocks(const FactorBatch& batch, const Part& part, Curvature curvature, double& cost);
  template <class Visit>
  void for_each_row(std::size_t first, std::size_t last, const Visit& visit) const;
  void add_outer_products();

  Resolved resolved_;
  bool thin_ = false;
  std::vector<Part> parts_;
  std::vector<char> whole_blocks_;           // of each batch: are whole blocks weighed?
  std::vector<double> r_, J_, Jd_, weight_;  // J as FactorBatch::evaluate writes it, batch after batch
  std::vector<char> in_pattern_;             // of each entry of J_
  // Rows by their entries that are not 0. After the residuals' own rows come, for every factor under a block loss, one row for the
  // rank-one part of Newton's curvature: (Jᵀr)ᵀ.
  std::vector<int> row_begin_, unknown_, source_;
  std::vector<double> value_;
  std::size_t entries_ = 0;              // while they are found
  std::vector<int> pair_begin_, place_;  // of each row: where the products of its entries go in H
  std::vector<double> gradient_weight_, hessian_weight_;
  // Unknowns: places in the tangent; position: in elimination order.
  std::vector<int> variable_of_, position_, order_, rows_begin_, rows_of_, first_;
  std::vector<char> seen_;
  std::vector<int> walked_;  // of each row: 1 + where the last walk that has been over it began
  EnvelopeCholesky cholesky_;
  std::vector<double> gradient_, damping_, step_, total_, tangent_;
};

}  // namespace holdfast::detail
