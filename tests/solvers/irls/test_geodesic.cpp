// Geodesic acceleration on a bend whose second derivatives are known.
#include <gtest/gtest.h>

#include <holdfast/factors/prior.hpp>
#include <holdfast/solvers/irls/internal/geodesic.hpp>

namespace holdfast::testing {
namespace {

using holdfast::detail::Geodesic;
using holdfast::detail::NewtonSystem;

constexpr Agent A('A');

/// r = (10 (y − x²), 1 − x): along δ, r̈ = (−20 δx², 0), and J a = −r̈ for a = (0, 2 δx²).
struct Valley {
  using Variables = variables<Point2>;
  static constexpr int residual_dim = 2;
  Vector<2> operator()(const Point2& p, Jacobians<Valley>* J = nullptr) const {
    const double x = p.value[0], y = p.value[1];
    if (J != nullptr) J->all << -20 * x, 10, -1, 0;
    return {10 * (y - x * x), 1 - x};
  }
};

class GeodesicTest : public ::testing::Test {
 protected:
  GeodesicTest() : values(at(0.7, 0.2)), graph(valley()), system(graph, values, 1), geodesic(graph, system) {
    system.linearize(graph, values, Curvature::irls);
    std::vector<double> newton(2);
    system.solve_damped(0, newton);
  }
  static Values at(double x, double y) {
    Values values;
    values.insert(A(0), Point2(x, y));
    return values;
  }
  static Graph valley() {
    Graph graph;
    graph.add(Valley{}, {A(0)});
    return graph;
  }
  bool bend(const Vector<2>& delta) {
    tangent = {delta[0], delta[1]};
    std::vector<double> step(2);
    system.from_tangent(tangent, step);
    Values moved = values;
    return geodesic.bend(graph, system, values, step, tangent, moved);
  }

  Values values;
  Graph graph;
  NewtonSystem system;
  Geodesic geodesic;
  std::vector<double> tangent;
};

TEST_F(GeodesicTest, AddsHalfTheAcceleration) {
  ASSERT_TRUE(bend({0.05, 0.1}));
  EXPECT_NEAR(tangent[0], 0.05, 1e-12);
  EXPECT_NEAR(tangent[1], 0.1 + 0.05 * 0.05, 1e-12);
}

TEST_F(GeodesicTest, KeepsResidualsOnTheirTangentPlane) {
  const Point2 start = values.at<Point2>(A(0));
  for (const Vector<2>& delta : {Vector<2>(0.05, 0.1), Vector<2>(-0.03, 0.2), Vector<2>(0.06, -0.02)}) {
    ASSERT_TRUE(bend(delta));
    Jacobians<Valley> J;
    const Vector<2> r = Valley{}(start, &J), straight = Valley{}(Point2(Vector<2>(start.value + delta)));
    const Vector<2> bent = Valley{}(Point2(Vector<2>(start.value + Vector<2>(tangent[0], tangent[1]))));
    const Vector<2> plane = r + J.all * delta;
    EXPECT_LT((bent - plane).norm(), 1e-10);
    EXPECT_GT((straight - plane).norm(), 1e-3);
  }
}

TEST_F(GeodesicTest, LeavesAStepThatTurnsTooMuch) {
  EXPECT_FALSE(bend({1, 0}));
  EXPECT_EQ(tangent, (std::vector<double>{1, 0}));
}

TEST_F(GeodesicTest, DoesNothingToAStraightStep) {
  ASSERT_TRUE(bend({0, 0.3}));
  EXPECT_NEAR(tangent[0], 0, 1e-12);
  EXPECT_NEAR(tangent[1], 0.3, 1e-12);
}

}  // namespace
}  // namespace holdfast::testing
