// What every back-end round a foreign optimizer does alike: the start is checked, and the answer scored by our own cost and gradient.
#pragma once

#include <holdfast/solvers/internal/minimizer.hpp>

namespace holdfast {

class ForeignBackend : public Backend {
 public:
  ForeignBackend(std::string name, const Options& chosen) : Backend(chosen), name_(std::move(name)) {}
  std::string name() const final { return name_; }

 protected:
  /// x: start in, answer out. Fills in the progress how it ended, its iterations and seconds.
  virtual void optimize(const Graph& graph, const Resolved& resolved, Values& x, Progress& progress) = 0;
  int iteration_limit() const { return options.max_iterations > 0 ? options.max_iterations : kMaxIterations; }

 private:
  static constexpr int kMaxIterations = 1000;
  Summary minimize(const Graph& graph, Values& values) final;

  std::string name_;
};

}  // namespace holdfast
