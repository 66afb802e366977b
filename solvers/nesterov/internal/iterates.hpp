// Nesterov's sequences x, y and t on a manifold, with L by backtracking and momentum that never points uphill. Internal.
#pragma once

#include <holdfast/graph/resolved.hpp>

namespace holdfast::detail {

class Iterates {
 public:
  /// x = y = values.
  Iterates(const Resolved& resolved, const Values& values);

  const Values& x() const { return x_; }  ///< the best so far
  const Values& y() const { return y_; }  ///< where the next step begins: ahead of x by the momentum
  bool plain() const { return plain_; }   ///< y = x: a step without momentum
  double L() const { return L_; }

  /// next = y ⊕ −(1/L) direction, L raised until f(next) ≤ f(y) − norm2 / 2L, norm2 = gᵀ direction; returns f(next), NaN where no L does.
  double backtrack(const Graph& graph, const Resolved& resolved, double cost_y, const std::vector<double>& direction, double norm2,
                   ThreadPool* pool);
  /// x = next, and y ahead of it by Nesterov's t. g: at the y before. A momentum that points uphill (gᵀ (next ⊖ x) > 0) is dropped.
  void accept(const Resolved& resolved, const std::vector<double>& g);
  /// Once more from x, without momentum and with L = 1.
  void restart();
  /// What the last bound no longer needs.
  void lower_L() { L_ *= 0.98; }

 private:
  /// y = next ⊕ β (next ⊖ x), x = next; returns gᵀ(next ⊖ x).
  double extrapolate(const Resolved& resolved, const std::vector<double>& g, double beta);

  Values x_, y_, next_;
  std::vector<double> step_, move_;
  double t_ = 1, L_ = 1;
  bool plain_ = true;
};

}  // namespace holdfast::detail
