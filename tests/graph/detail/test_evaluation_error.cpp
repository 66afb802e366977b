// A loss that fails while a back-end evaluates it: the solve fails with its words, and the values stay.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <holdfast/factors/prior.hpp>
#include <holdfast/graph/detail/evaluation_error.hpp>
#include <holdfast/graph/graph.hpp>
#include <holdfast/solvers/table.hpp>
#include <limits>

namespace holdfast::testing {
namespace {

/// Squared, until it has been asked `patience` times.
class Tires final : public holdfast::detail::OwnLoss, public holdfast::detail::FallibleLoss {
 public:
  explicit Tires(int patience) : patience_(patience) {}
  std::type_index type() const override { return typeid(Tires); }
  Rho rho(double s, int) const override {
    if (patience_-- > 0) return {s, 1, 0};
    error_ = "tired of it";
    const double nan = std::numeric_limits<double>::quiet_NaN();
    return {nan, nan, nan};
  }
  bool is_convex() const override { return true; }
  Loss relaxed() const override { return {}; }
  void validate() const override {}
  bool equals(const OwnLoss& other) const override { return this == &other; }
  std::string name() const override { return "Tires"; }
  const double* scale() const override { return nullptr; }
  std::string take_error() const override { return std::exchange(error_, std::string()); }

 private:
  mutable int patience_;
  mutable std::string error_;
};

Loss tires(int patience) {
  Loss loss;
  loss.kind = Loss::Kind::Own;
  loss.own = std::make_shared<Tires>(patience);
  return loss;
}

TEST(EvaluationError, OfALossIsToldOnceAndForgotten) {
  Graph graph;
  graph.add(Prior<Point2>::from_sigmas(Point2(1, 2), Vector<2>(1, 1)), {Key('A', 0)}, tires(0));
  graph.add(Prior<Point2>::from_sigmas(Point2(1, 2), Vector<2>(1, 1)), {Key('A', 1)}, tires(9));
  Values values;
  values.insert(Key('A', 0), Point2(0, 0));
  values.insert(Key('A', 1), Point2(0, 0));
  (void)graph.cost(values);
  EXPECT_EQ(holdfast::detail::take_error(*graph.batches().front()), "tired of it");
  EXPECT_EQ(holdfast::detail::take_error(*graph.batches().front()), "");
}

TEST(EvaluationError, OfALossFailsTheSolveAndLeavesTheValues) {
  for (const char* backend : {"irls", "nesterov"}) {
    SCOPED_TRACE(backend);
    Graph graph;
    graph.add(Prior<Pose2>::from_sigmas(Pose2(1, 2, 3), Vector<3>(1, 1, 1)), {Key('A', 0)}, tires(2));
    Values values;
    values.insert(Key('A', 0), Pose2(0, 0, 0.1));
    const Summary summary = make_backend(backend)->solve(graph, values);
    EXPECT_EQ(summary.termination, Termination::failed);
    EXPECT_THAT(summary.str(), ::testing::HasSubstr("tired of it"));
    EXPECT_EQ(values.at<Pose2>(Key('A', 0)).p, Vector<2>(0, 0));
  }
}

}  // namespace
}  // namespace holdfast::testing
