// A solve that fails leaves the caller's values as they were, however badly the back-end behaves.
#include <gtest/gtest.h>

#include "tests/backends.hpp"
#include "tests/counting_new.hpp"
#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

constexpr Agent A('A');

/// Spoils the values it is given, and then ends as it is told.
class Spoiler final : public Backend {
 public:
  enum class End { fails, throws, erases, inserts, succeeds };
  explicit Spoiler(End end) : end_(end) {}
  std::string name() const override { return "spoiler"; }

 protected:
  Summary minimize(const Graph&, Values& values) override {
    values.at<Point2>(A(0)).value = Vector<2>(77, 78);
    Summary summary;
    summary.termination = end_ == End::fails ? Termination::failed : Termination::converged;
    if (end_ == End::throws) fail<BadNumber>("thrown half way");
    if (end_ == End::erases) values.erase(A(1));
    if (end_ == End::inserts) values.insert(A(2), Point2(5, 5));
    return summary;
  }

 private:
  End end_;
};

class UnchangedOnFailure : public ::testing::Test {
 protected:
  UnchangedOnFailure() {
    graph.add(Prior<Point2>::from_sigmas(Point2(1, 2), {0.5, 0.5}), {A(0)});
    values.insert(A(0), Point2(4, 2));
    values.insert(A(1), Point2(0.1, 0.2));
    start = values;
  }
  Graph graph;
  Values values, start;
};

TEST_F(UnchangedOnFailure, WhereTheBackEndFailsAfterChangingThem) {
  EXPECT_FALSE(Spoiler(Spoiler::End::fails).solve(graph, values).usable());
  EXPECT_TRUE(same_bits(values, start));
}

TEST_F(UnchangedOnFailure, WhereTheBackEndThrowsAfterChangingThem) {
  EXPECT_THROW(Spoiler(Spoiler::End::throws).solve(graph, values), BadNumber);
  EXPECT_TRUE(same_bits(values, start));
}

TEST_F(UnchangedOnFailure, WhereTheBackEndAddsOrErasesVariables) {
  for (const auto end : {Spoiler::End::erases, Spoiler::End::inserts}) {
    const Summary summary = Spoiler(end).solve(graph, values);
    EXPECT_EQ(summary.termination, Termination::failed);
    EXPECT_EQ(summary.why(), "the back-end added or erased variables: spoiler");
    EXPECT_EQ(values.keys(), start.keys());
    EXPECT_TRUE(same_bits(values, start));
  }
}

TEST_F(UnchangedOnFailure, AnAnswerArrivesWhereReferencesPoint) {
  const Point2& held = values.at<Point2>(A(0));
  EXPECT_TRUE(Spoiler(Spoiler::End::succeeds).solve(graph, values).usable());
  EXPECT_EQ(held.value, Vector<2>(77, 78));
}

TEST_F(UnchangedOnFailure, AllocatesNothingForAStructureMetBefore) {
  Spoiler backend(Spoiler::End::fails);
  backend.solve(graph, values);
  allocations = 0;
  counting = true;
  backend.solve(graph, values);
  counting = false;
  EXPECT_EQ(allocations, 0);
}

/// While it runs, a callback sees the start.
TEST(UntilASolveReturns, ItsValuesHoldTheStart) {
  for (const std::string& name : every_backend()) {
    const auto problem = slam<Pose2>(1, 6, 0.1);
    Values values = problem.start;
    Options options;
    int calls = 0;
    options.progress = [&](const Iteration&) {
      ++calls;
      EXPECT_TRUE(same_bits(values, problem.start)) << name;
      return true;
    };
    EXPECT_TRUE(make_backend(name, options)->solve(problem.graph, values).usable()) << name;
    EXPECT_GT(calls, 1) << name;
    EXPECT_FALSE(same_bits(values, problem.start)) << name;
  }
}

}  // namespace
}  // namespace holdfast::testing
