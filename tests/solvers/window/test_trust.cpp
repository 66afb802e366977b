#include <gtest/gtest.h>

#include <holdfast/solvers/window/trust.hpp>

#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

constexpr Agent A('A'), L('L');

TEST(Trust, IsLostWhenMostOfTheLatestDoNotFitAndComesBack) {
  Trust trust;
  std::uint64_t ticket = 0;
  for (int i = 0; i < 20; ++i) EXPECT_EQ(trust.judge(1, ticket++, i % 3 != 0), Trust::Change::none);  // a third misfits: believed
  EXPECT_TRUE(trust.is_believed(1));
  int misfits = 0;
  while (trust.judge(1, ticket++, false) == Trust::Change::none) ASSERT_LT(++misfits, 8);
  EXPECT_FALSE(trust.is_believed(1));
  EXPECT_EQ(trust.disbelieved(), std::vector<std::uint64_t>{1});
  for (int i = 0; i < 50; ++i) EXPECT_EQ(trust.judge(1, ticket++, i % 2 == 0), Trust::Change::none);  // half of them: not yet
  int fits = 0;
  while (trust.judge(1, ticket++, true) == Trust::Change::none) ASSERT_LT(++fits, 8);
  EXPECT_TRUE(trust.is_believed(1));
  trust.disbelieve(1);
  EXPECT_FALSE(trust.is_believed(1));
  EXPECT_TRUE(trust.is_believed(2));  // never heard of
}

TEST(Trust, DoubtfulBeginsWithTheFirstThatDoesNotFit) {
  Trust trust;
  trust.judge(7, 100, true);
  trust.judge(7, 101, false);
  trust.judge(7, 102, true);
  const auto doubtful = trust.doubtful(7);
  ASSERT_EQ(doubtful.size(), 2u);
  EXPECT_EQ(doubtful[0].ticket, 101u);
  EXPECT_EQ(trust.latest(7).size(), 3u);
}

// A single misfit of a party just met is no reason, and a party that is not believed needs as many as any other.
TEST(Trust, CountsFromTheBeginning) {
  Trust trust;
  for (int i = 0; i < 4; ++i) EXPECT_EQ(trust.judge(1, 0, false), Trust::Change::none);
  EXPECT_EQ(trust.judge(1, 0, false), Trust::Change::lost);
}

TEST(Trust, NamesWhatIsWrong) {
  EXPECT_THROW(Trust({1, 3, 0.5, 0.75}), BadOption);
  EXPECT_THROW(Trust({8, 0, 0.5, 0.75}), BadOption);
  EXPECT_THROW(Trust({8, 3, 1, 0.75}), BadOption);
  EXPECT_THROW(Trust({8, 3, 0.5, 0.25}), BadOption);
  EXPECT_THROW(innovation(Graph(), Values(), Marginals(slam<Pose2>(1, 3, 0.1).graph, slam<Pose2>(1, 3, 0.1).start)), BadProblem);
}

// By hand: a position known to 3 m on each axis, a beacon known exactly, a range of sigma 4 m along x that is 10 m off: 100 / (16 + 9).
TEST(Trust, InnovationIsTheResidualInTheSigmasOfAllThatIsKnown) {
  Graph graph;
  Values values;
  values.insert(A(0), Point2(0, 0));
  values.insert(L(0), Point2(20, 0));
  graph.add(Prior<Point2>::from_sigmas(Point2(0, 0), Vector<2>(3, 3)), {A(0)});
  graph.add(Prior<Point2>::from_sigmas(Point2(20, 0), Vector<2>(1, 1)), {L(0)});
  graph.fix(L(0));
  Graph one;
  one.add(Range<Point2, Point2>{30, 4}, {A(0), L(0)});
  EXPECT_NEAR(innovation(one, values, Marginals(graph, values)), 100.0 / 25, 1e-12);
}

}  // namespace
}  // namespace holdfast::testing
