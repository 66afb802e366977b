// What elimination leaves on any number of variables, of mixed types: the one factor of run-time size.
//
//   r(x) = b + A δ,   δ_k = x0_k.local(x_k)            (x0: where it was linearised; A: rows × Σ dim)
//
// On vector spaces it is linear, on others as good as A was at x0. It is made of terms already weighed, so its loss is Squared
// and weighs 1 unless Graph::set_weight says otherwise. Made by marginalize() (solvers/window/marginalize.hpp), or by hand:
//
//   LinearPrior prior;
//   prior.add_variable(A(3), x3);                      // x3: a Pose2 at which r is b
//   prior.add_variable(L(0), l0);
//   prior.rows = 5; prior.A = …; prior.b = …;
//   graph.add(prior);
#pragma once

#include <holdfast/graph/batch.hpp>

namespace holdfast {

struct LinearPrior {
  std::vector<Key> keys;
  std::vector<const PoolBase*> types;  ///< of each variable: Pool<V>::prototype()
  std::vector<double> x0;              ///< ambient coordinates, one variable after the other
  int rows = 0;                        ///< > 0
  std::vector<double> A;               ///< rows × Σ dim, column-major
  std::vector<double> b;               ///< rows
  /// The part of the cost of the terms it replaces that no value of these variables can change; graph.cost() does not have it.
  double constant = 0;
  static const char* name() { return "LinearPrior"; }

  template <class V>
  void add_variable(Key key, const V& at) {
    add_variable(key, Pool<V>::prototype(), reinterpret_cast<const double*>(&at));
  }
  void add_variable(Key key, const PoolBase& type, const double* at);
  void clear();

  int columns() const;  ///< Σ dim
  /// Throws BadNumber for sizes that do not fit and for numbers that are not finite.
  void validate() const;
};

/// Holds one LinearPrior, or, after Graph::remove, the memory for the next one.
class LinearPriorBatch final : public FactorBatch {
 public:
  LinearPriorBatch();
  void hold(const LinearPrior& prior);
  const LinearPrior& prior() const { return prior_; }

  void evaluate(const Values& values, const int* index, int first, int last, double* r, double* J) const override;
  void evaluate_at(int i, const double* const* ambient, double* r, double* J) const override;
  std::unique_ptr<FactorBatch> clone() const override { return std::make_unique<LinearPriorBatch>(*this); }

 private:
  std::unique_ptr<FactorBatch> make_empty(const Loss&) const override { return std::make_unique<LinearPriorBatch>(); }
  void push_from(const FactorBatch& other, int) override { hold(static_cast<const LinearPriorBatch&>(other).prior_); }
  void erase(int) override {}
  void local(const double* const* x, double* delta) const;
  void residual(const double* delta, double* r) const;
  void times_local_jacobians(const double* const* x, double* J) const;

  LinearPrior prior_;
};

}  // namespace holdfast
