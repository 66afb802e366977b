// Nesterov's sequences on ½ (x / σ)², where every number is known by hand.
#include <gtest/gtest.h>

#include <holdfast/factors/prior.hpp>
#include <holdfast/solvers/nesterov/internal/iterates.hpp>

namespace holdfast::testing {
namespace {

using holdfast::detail::Iterates;

constexpr Key kX('X', 0);

class IteratesTest : public ::testing::Test {
 protected:
  void begin(double x, double sigma) {
    graph.add(Prior<Scalar>::from_sigmas(Scalar(0.0), Vector<1>(sigma)), {kX});
    values.insert(kX, Scalar(x));
    resolved = Resolved(graph, values);
    iterates = std::make_unique<Iterates>(resolved, values);
  }
  static double of(const Values& values) { return values.at<Scalar>(kX).value; }
  /// One step along the gradient g of f at y, in the metric 1.
  double backtrack(double g) { return iterates->backtrack(graph, resolved, graph.cost(iterates->y()), {g}, g * g, nullptr); }

  Graph graph;
  Values values;
  Resolved resolved;
  std::unique_ptr<Iterates> iterates;
};

TEST_F(IteratesTest, AStepThatTheBoundAllowsIsTakenInFull) {
  begin(4, 1);  // f'' = 1 = L
  EXPECT_EQ(backtrack(4), 0);
  EXPECT_EQ(iterates->L(), 1);
}

// f = 50 x², f'' = 100: with q = 100 / L the bound is (1 − q)² ≤ 1 − q, so L must reach 100: 128 is the first power of two there.
TEST_F(IteratesTest, LIsRaisedUntilTheCostFallsAsMuchAsItMust) {
  begin(4, 0.1);
  const double cost = backtrack(400);
  EXPECT_EQ(iterates->L(), 128);
  EXPECT_NEAR(cost, 50 * 16 * std::pow(1 - 100.0 / 128, 2), 1e-10);
}

TEST_F(IteratesTest, AStepUphillIsShortenedUntilItIsRounding) {
  begin(4, 1);
  EXPECT_NEAR(backtrack(-4), 8, 1e-12);
  EXPECT_GT(iterates->L(), 1e12);
}

TEST_F(IteratesTest, ADirectionThatIsNoNumberEndsTheSearch) {
  begin(4, 1);
  EXPECT_TRUE(std::isnan(backtrack(NAN)));
}

TEST_F(IteratesTest, MomentumGrowsByNesterovsT) {
  begin(4, 1);
  backtrack(1);  // x: 4 → 3
  iterates->accept(resolved, {4});
  EXPECT_EQ(of(iterates->x()), 3);
  EXPECT_EQ(of(iterates->y()), 3);  // t = 1: no momentum yet
  EXPECT_TRUE(iterates->plain());
  backtrack(1);  // 3 → 2
  iterates->accept(resolved, {3});
  const double t1 = (1 + std::sqrt(5)) / 2, t2 = (1 + std::sqrt(1 + 4 * t1 * t1)) / 2;
  EXPECT_EQ(of(iterates->x()), 2);
  EXPECT_NEAR(of(iterates->y()), 2 - (t1 - 1) / t2, 1e-12);
  EXPECT_FALSE(iterates->plain());
}

TEST_F(IteratesTest, MomentumThatPointsUphillIsDropped) {
  begin(4, 1);
  backtrack(1);
  iterates->accept(resolved, {4});
  backtrack(1);
  iterates->accept(resolved, {-3});  // the move is −1, the gradient there says that down is the other way
  EXPECT_EQ(of(iterates->x()), 2);
  EXPECT_EQ(of(iterates->y()), 2);
  EXPECT_TRUE(iterates->plain());
  backtrack(1);
  iterates->accept(resolved, {2});
  EXPECT_EQ(of(iterates->y()), 1);  // t began again at 1
}

TEST_F(IteratesTest, ARestartIsFromXWithoutMomentum) {
  begin(4, 0.1);
  backtrack(400);
  iterates->accept(resolved, {400});
  backtrack(100);
  iterates->accept(resolved, {100});
  ASSERT_NE(of(iterates->x()), of(iterates->y()));
  const double x = of(iterates->x());
  iterates->restart();
  EXPECT_EQ(of(iterates->x()), x);
  EXPECT_EQ(of(iterates->y()), x);
  EXPECT_EQ(iterates->L(), 1);
  EXPECT_TRUE(iterates->plain());
  iterates->lower_L();
  EXPECT_EQ(iterates->L(), 0.98);
}

}  // namespace
}  // namespace holdfast::testing
