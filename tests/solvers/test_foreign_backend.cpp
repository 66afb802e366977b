// What a back-end round a foreign optimizer answers for, whatever the optimizer: here, one that jumps to a place.
#include <gtest/gtest.h>

#include <holdfast/solvers/internal/foreign_backend.hpp>

#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

constexpr Agent A('A');

class Jump final : public ForeignBackend {
 public:
  Jump(const Point2& place, Termination termination) : ForeignBackend("jump", Options{}), place_(place), termination_(termination) {}

 protected:
  void optimize(const Graph&, const Resolved&, Values& x, Progress& progress) override {
    x.update(A(0), place_);
    progress.end(termination_, "it jumped");
  }

 private:
  Point2 place_;
  Termination termination_;
};

class ForeignBackendTest : public ::testing::Test {
 protected:
  ForeignBackendTest() {
    graph.add(Prior<Point2>::from_sigmas(Point2(1, 2), {0.5, 0.5}), {A(0)});
    values.insert(A(0), Point2(4, 2));
  }
  Graph graph;
  Values values;
};

TEST_F(ForeignBackendTest, TheAnswerIsScoredByOurCostAndGradient) {
  const Summary summary = Jump(Point2(1, 3), Termination::converged).solve(graph, values);
  EXPECT_EQ(summary.termination, Termination::converged);
  EXPECT_DOUBLE_EQ(summary.cost_first, 18);  // ½ (3 / 0.5)²
  EXPECT_DOUBLE_EQ(summary.cost, 2);
  EXPECT_DOUBLE_EQ(summary.gradient_norm, 4);  // 1 m / 0.5² m²
  EXPECT_EQ(values.at<Point2>(A(0)).value, Point2(1, 3).value);
}

TEST_F(ForeignBackendTest, AnEndAboveTheStartIsAFailure) {
  const Summary summary = Jump(Point2(9, 9), Termination::converged).solve(graph, values);
  EXPECT_EQ(summary.termination, Termination::failed);
  EXPECT_EQ(summary.cost, summary.cost_first);
  EXPECT_EQ(values.at<Point2>(A(0)).value, Point2(4, 2).value);
}

TEST_F(ForeignBackendTest, NoNumberIsAFailure) {
  EXPECT_FALSE(Jump(Point2(NAN, 2), Termination::converged).solve(graph, values).usable());
  EXPECT_EQ(values.at<Point2>(A(0)).value, Point2(4, 2).value);
}

TEST_F(ForeignBackendTest, WhatAFailedOptimizerLeftIsNotLookedAt) {
  const Summary summary = Jump(Point2(1, 2), Termination::failed).solve(graph, values);
  EXPECT_FALSE(summary.usable());
  EXPECT_EQ(summary.cost, summary.cost_first);
  EXPECT_EQ(values.at<Point2>(A(0)).value, Point2(4, 2).value);
}

TEST_F(ForeignBackendTest, NothingFreeIsNoProblem) {
  graph.fix(A(0));
  EXPECT_THROW(Jump(Point2(1, 2), Termination::converged).solve(graph, values), BadProblem);
}

}  // namespace
}  // namespace holdfast::testing
