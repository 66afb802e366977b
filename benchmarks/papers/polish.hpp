// The last digits of an answer, the same from every back-end.
//
// A back-end that compares costs stops where costs have no more digits: √ε before the minimum, and further from it where it converges
// slowly (Ceres leaves out ρ'' and creeps under Huber). Newton's steps on the gradient go the rest of the way: micrometres in paper A's
// windows.
#pragma once

#include <holdfast/benchmarks/papers/newton_backend.hpp>

namespace holdfast::bench {

class Polish {
 public:
  Polish() {
    newton_.irls_options.reweighting = Reweighting::newton;
    newton_.options.cost_tolerance = 0;
    newton_.options.gradient_tolerance = kFlat;
  }

  /// After a solve of this graph that ended with `summary`.
  void operator()(const Graph& graph, Values& values, const Summary& summary) { (void)with(newton_, graph, values, summary); }

  /// The same by another back-end that takes Newton's steps; returns the summary of where it ends.
  static Summary with(Backend& newton, const Graph& graph, Values& values, Summary summary) {
    if (!summary.usable()) return summary;
    // A solve ends with the first step that lowers the cost no more: each is one step here.
    for (int i = 0; i < kMost && summary.gradient_norm > kFlat; ++i) {
      const Summary step = newton.solve(graph, values);
      summary.cost = step.cost;
      summary.gradient_norm = step.gradient_norm;
    }
    return summary;
  }

 private:
  static constexpr int kMost = 50;
  static constexpr double kFlat = 1e-9;  ///< largest component of the gradient, whitened
  Irls newton_;
};

/// A back-end that solves to the last digit.
class Polished final : public Backend {
 public:
  explicit Polished(const std::string& name) : inner_(newton_backend(name, last_digit())), newton_(newton_backend("irls", last_digit())) {
    options = inner_->options;
  }
  std::string name() const override { return inner_->name(); }

 protected:
  Summary minimize(const Graph& graph, Values& values) override {
    inner_->options = options;
    // An inner back-end that is Newton's method itself knows this structure already.
    Backend& newton = inner_->name() == newton_->name() ? *inner_ : *newton_;
    return Polish::with(newton, graph, values, inner_->solve(graph, values));
  }

 private:
  static Options last_digit() {
    Options options;
    options.cost_tolerance = 0;
    return options;
  }
  std::unique_ptr<Backend> inner_, newton_;
};

}  // namespace holdfast::bench
