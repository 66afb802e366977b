// Factors whose residual is a function given at run time, of all of them at once: what a binding to another language is made of.
//
//   auto range = std::make_shared<FunctionFactors>();
//   range->name = "MyRange";
//   range->types = {&Pool<Pose2>::prototype(), &Pool<Point2>::prototype()};
//   range->residual_dim = 1;
//   range->evaluate = [=](const FunctionCall& call) { … call.r[i] = … };
//   graph.add(range, {x(0), L(0), x(1), L(0)}, Huber{2});      // two factors: number 0 and number 1
//
// A function is called for whole batches, so that its overhead is paid once an evaluation. Whatever it throws ends a solve as failed, with
// what it said (FactorBatch::take_error); the values are then as they were.
// Threads. It is called by one thread at a time for one batch; copies of a graph share the function, and may call it at once.
#pragma once

#include <functional>
#include <holdfast/graph/batch.hpp>
#include <mutex>

namespace holdfast {

/// n factors to evaluate. All arrays are row by row, a row a factor.
struct FunctionCall {
  int n = 0;
  const int* number = nullptr;   ///< of each factor, in the order in which they were added to the graph for this function
  std::vector<const double*> x;  ///< of each variable: n × ambient dimension, its coordinates as Pool<V>::data() has them
  double* r = nullptr;           ///< out: n × residual_dim, whitened
  std::vector<double*> J;        ///< out: of each variable n × residual_dim × dim, d r / d tangent; empty where not asked for
};

struct FunctionFactors {
  std::string name = "Function";
  std::vector<const PoolBase*> types;  ///< of each variable: &Pool<V>::prototype()
  int residual_dim = 1;                ///< > 0
  bool has_jacobian = false;           ///< it fills J where asked; else J is by central differences of 1e-6, two more calls a tangent entry
  std::function<void(const FunctionCall&)> evaluate;
  mutable int given = 0;  ///< numbers that were given out

  /// Throws BadOption with field, value and rule.
  void validate() const;
};

class FunctionBatch final : public FactorBatch {
 public:
  FunctionBatch(std::shared_ptr<const FunctionFactors> function, const Loss& loss);
  FunctionBatch(const FunctionBatch& other);

  void evaluate(const Values& values, const int* index, int first, int last, double* r, double* J) const override;
  void evaluate_at(int i, const double* const* ambient, double* r, double* J) const override;
  std::unique_ptr<FactorBatch> clone() const override { return std::make_unique<FunctionBatch>(*this); }
  bool takes_factors_of(const FactorBatch& other) const override;
  std::string take_error() const override;

  const std::shared_ptr<const FunctionFactors>& function() const { return function_; }
  void push(int number) { numbers_.push_back(number); }

 private:
  std::unique_ptr<FactorBatch> make_empty(const Loss& loss) const override { return std::make_unique<FunctionBatch>(function_, loss); }
  void push_from(const FactorBatch& other, int i) override { push(static_cast<const FunctionBatch&>(other).numbers_[i]); }
  void erase(int i) override;

  /// x: of each factor the coordinates of its variables, one after the other. J as evaluate() writes it, or null.
  void compute(int n, const int* numbers, const double* x, double* r, double* J) const;
  void call(int n, const int* numbers, const std::vector<std::vector<double>>& x, double* r, std::vector<std::vector<double>>* J) const;
  void differences(int n, const int* numbers, std::vector<std::vector<double>>& x, double* J) const;

  std::shared_ptr<const FunctionFactors> function_;
  std::vector<int> numbers_;
  int ambient_ = 0;  // of all variables of a factor

  // What the whole batch was last evaluated at: chunks of one evaluation are asked for one by one.
  mutable std::mutex mutex_;
  mutable std::vector<double> x_, r_, J_;
  mutable bool has_J_ = false;
  mutable std::string error_;
};

}  // namespace holdfast
