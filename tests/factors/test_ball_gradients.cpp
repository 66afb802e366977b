// What the balls' gradients without r and J are: the same as those from r and J.
#include <gtest/gtest.h>

#include <holdfast/factors/missing_distance.hpp>
#include <holdfast/factors/range_ball.hpp>
#include <holdfast/graph/gradient.hpp>
#include <holdfast/testing.hpp>

namespace holdfast::testing {
namespace {

constexpr Agent N('N');

/// Of one factor between N0 and N1, under a loss and a weight: cost and gradient against w ρ' Jᵀr.
template <class F, class V>
void expect_gradient(const F& factor, const V& a, const V& b, const Loss& loss) {
  Graph graph;
  Values values;
  values.insert(N(0), a);
  values.insert(N(1), b);
  graph.add(factor, {N(0), N(1)}, loss, 0.7);
  Jacobians<F> J;
  const Residual<F> r = factor(a, b, &J);
  const Rho rho = loss.rho(r.squaredNorm(), F::residual_dim);
  const Vector<F::Variables::total_dim> expected = 0.7 * rho.first * J.all.transpose() * r;
  const Gradient found = gradient(graph, values);
  for (int i = 0; i < expected.size(); ++i) EXPECT_NEAR(found.value[i], expected[i], 1e-12 * (1 + expected.norm()));
  const Resolved resolved(graph, values);
  std::vector<double> g;
  EXPECT_NEAR(GradientEvaluator(graph)(graph, resolved, values, g), graph.cost(values), 1e-12 * (1 + graph.cost(values)));
}

template <class V>
void expect_gradients() {
  std::mt19937_64 rng(3);
  constexpr int D = V::dim;
  for (int run = 0; run < 100; ++run) {
    const V a(random_vector<D>(rng, 3)), b(random_vector<D>(rng, 3));
    for (const Loss& loss : {Loss(Squared{}), Loss(Huber{1}), Loss(Cauchy{1}), per_component(Huber{1000})}) {
      const double d = uniform(rng, 0, 6);  // in half of the runs a is within the ball
      expect_gradient(RangeBall<V, V>{d, 0.3}, a, b, loss);
      expect_gradient(MissingDistance<V, V>{d, 0.3, 0.4}, a, b, loss);
    }
  }
  const V p(random_vector<D>(rng, 3));
  V next = p;
  next.value[0] += 1e-10;
  for (const double d : {0.0, 1.0})
    for (const V& b : {p, next}) expect_gradient(RangeBall<V, V>{d, 0.3}, p, b, Squared{});
}

TEST(BallGradients, AreThoseOfResidualAndJacobianInThePlane) { expect_gradients<Point2>(); }
TEST(BallGradients, AreThoseOfResidualAndJacobianInSpace) { expect_gradients<Point3>(); }

TEST(BallGradients, ByHand) {  // 5 m apart, 2 m measured, σ = ½: r = 3 / ½ along (0.6, 0.8)
  Graph graph;
  Values values;
  values.insert(N(0), Point2(1, 1));
  values.insert(N(1), Point2(4, 5));
  graph.add(RangeBall<Point2, Point2>{2, 0.5}, {N(0), N(1)});
  const Gradient found = gradient(graph, values);
  const double slope = 3 / 0.25;
  const double expected[] = {-0.6 * slope, -0.8 * slope, 0.6 * slope, 0.8 * slope};
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(found.value[i], expected[i], 1e-12);
}

// A NaN is no distance within the ball.
TEST(BallGradients, ANumberThatIsNoneStaysOne) {
  Graph graph;
  Values values;
  values.insert(N(0), Point2(NAN, 1));
  values.insert(N(1), Point2(4, 5));
  graph.add(RangeBall<Point2, Point2>{2, 0.5}, {N(0), N(1)});
  EXPECT_TRUE(std::isnan(gradient(graph, values).value[2]));
}

}  // namespace
}  // namespace holdfast::testing
