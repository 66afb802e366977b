#include <gtest/gtest.h>

#include <holdfast/factors/range_bearing_ball.hpp>
#include <holdfast/graph/variables.hpp>
#include <holdfast/testing.hpp>
#include <vector>

#include "tests/conforms.hpp"

namespace holdfast {
namespace {

using testing::random_unit;
using testing::random_vector;
using testing::uniform;
using Ball = RangeBearingBall<Point2, Point2>;

const Point2 kOrigin(0, 0);

double cost(const Ball& ball, const Vector<2>& x) { return 0.5 * ball(kOrigin, Point2(x)).squaredNorm(); }

/// Paper C (6) + (7) of one edge, plus the constant κ.
double lifted_cost(const Ball& ball, const Vector<2>& x, const Vector<2>& y) {
  return 0.5 * (x - y).squaredNorm() / (ball.sigma * ball.sigma) + ball.kappa * (1 - ball.direction.dot(y) / ball.distance);
}

Ball random_ball(std::mt19937_64& rng) { return {uniform(rng, 1, 5), uniform(rng, 0.3, 1), random_unit<2>(rng), uniform(rng, 1, 20)}; }

TEST(RangeBearingBall, IsTheLeastLiftedCostOverTheBall) {
  std::mt19937_64 rng(1);
  for (int draw = 0; draw < 4; ++draw) {
    const Ball ball = random_ball(rng);
    const Vector<2> x = random_vector<2>(rng, 4);
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i <= 400; ++i)
      for (int k = 0; k < 800; ++k) {
        const double radius = ball.distance * i / 400, angle = 2 * kPi * k / 800;
        least = std::min(least, lifted_cost(ball, x, radius * Vector<2>(std::cos(angle), std::sin(angle))));
      }
    EXPECT_LE(cost(ball, x), least + 1e-9 * least);
    EXPECT_NEAR(cost(ball, x), least, 2e-3 * (1 + least));
  }
}

TEST(RangeBearingBall, IsZeroAtTheMeasuredPointOnly) {
  const Ball ball{5, 0.5, {0.6, 0.8}, 10};
  EXPECT_LT(ball(kOrigin, Point2(3, 4)).norm(), 1e-14);
  EXPECT_GT(cost(ball, {-3, -4}), 1);
  EXPECT_GT(cost(ball, {0, 0}), 1);
}

TEST(RangeBearingBall, IsLinearInsideTheShiftedBall) {
  const Ball ball{5, 0.5, {1, 0}, 4};                                // shifted by σ²κ/d = 0.2
  EXPECT_NEAR(cost(ball, {-0.2, 0}), 0.5 * 0.04 / 0.25 + 4, 1e-12);  // y = 0: the direction says nothing
  EXPECT_NEAR(cost(ball, {1, 0}) - cost(ball, {0, 0}), -4.0 / 5, 1e-12);
  EXPECT_NEAR(cost(ball, {0, 3}) - cost(ball, {0, 0}), 0, 1e-12);
}

TEST(RangeBearingBall, GradientIsThatOfTheCostAlsoAcrossTheBorder) {
  std::mt19937_64 rng(2);
  for (int draw = 0; draw < 200; ++draw) {
    const Ball ball = random_ball(rng);
    const double shift = ball.sigma * ball.sigma * ball.kappa / ball.distance;
    // On the border ‖x + shift u‖ = d, just off it on both sides, and anywhere.
    const double off = std::vector<double>{0, 1e-7, -1e-7, uniform(rng, -0.9, 3)}[draw % 4];
    const Vector<2> x = ball.distance * (1 + off) * random_unit<2>(rng) - shift * ball.direction;
    Jacobians<Ball> J;
    const auto r = ball(kOrigin, Point2(x), &J);
    const Vector<2> gradient = J.wrt<1>().transpose() * r;
    for (int i = 0; i < 2; ++i) {
      const Vector<2> step = Vector<2>::Unit(i) * 1e-6;
      EXPECT_NEAR(gradient[i], (cost(ball, x + step) - cost(ball, x - step)) / 2e-6, 1e-4 * (1 + gradient.norm())) << off;
    }
  }
}

TEST(RangeBearingBall, ResidualIsContinuousAcrossTheBorder) {
  std::mt19937_64 rng(3);
  for (int draw = 0; draw < 20; ++draw) {
    const Ball ball = random_ball(rng);
    const double shift = ball.sigma * ball.sigma * ball.kappa / ball.distance;
    const Vector<2> out = random_unit<2>(rng);
    const auto at = [&](double radius) { return ball(kOrigin, Point2(radius * out - shift * ball.direction)); };
    EXPECT_LT((at(ball.distance * (1 + 1e-9)) - at(ball.distance * (1 - 1e-9))).norm(), 1e-6);
  }
}

TEST(RangeBearingBall, JacobianIsExactOnBothSidesAndWherePositionsCoincide) {
  std::mt19937_64 rng(4);
  const RangeBearingBall<Pose3, Point3> ball{4, 0.5, {0, 0.6, 0.8}, 10};
  for (const double radius : {0.0, 1.0, 3.0, 5.0, 40.0}) {
    const Pose3 a = testing::random_variable<Pose3>(rng);
    EXPECT_LT(testing::jacobian_error(ball, a, Point3((a.p + radius * random_unit<3>(rng)).eval())), 1e-8) << radius;
  }
  EXPECT_LT(testing::jacobian_error(ball, Pose3(), Point3(0, 2.4, 3.2)), 1e-8);  // at its optimum
}

TEST(RangeBearingBall, CostIsConvex) {
  std::mt19937_64 rng(5);
  for (int draw = 0; draw < 500; ++draw) {
    const Ball ball = random_ball(rng);
    const Vector<2> x = random_vector<2>(rng, 5), y = random_vector<2>(rng, 5);
    EXPECT_LE(cost(ball, (x + y) / 2), (cost(ball, x) + cost(ball, y)) / 2 * (1 + 1e-12));
  }
}

TEST(RangeBearingBall, NeverCostsMoreThanTheExactTerms) {
  std::mt19937_64 rng(6);
  for (int draw = 0; draw < 500; ++draw) {
    const Ball ball = random_ball(rng);
    const Vector<2> e = random_unit<2>(rng);  // at distance d the exact range term is zero, the bearing term κ (1 − uᵀe)
    EXPECT_LE(cost(ball, ball.distance * e), ball.kappa * (1 - ball.direction.dot(e)) * (1 + 1e-12) + 1e-12);
  }
}

TEST(RangeBearingBall, RefusesNumbersThatAreNone) {
  EXPECT_THROW((Ball{0, 1, {1, 0}, 1}).validate(), BadNumber);
  EXPECT_THROW((Ball{1, 0, {1, 0}, 1}).validate(), BadNumber);
  EXPECT_THROW((Ball{1, 1, {1, 1}, 1}).validate(), BadNumber);
  EXPECT_THROW((Ball{1, 1, {1, 0}, -1}).validate(), BadNumber);
  EXPECT_THROW((Ball{NAN, 1, {1, 0}, 1}).validate(), BadNumber);
}

}  // namespace
}  // namespace holdfast

namespace holdfast::testing {

template <class A, class B>
struct Sample<RangeBearingBall<A, B>> : RandomVariables<RangeBearingBall<A, B>> {
  static RangeBearingBall<A, B> factor(std::mt19937_64& rng) {
    const double distance = radius(rng), sigma = uniform(rng, 0.5, 1);
    const double shift = uniform(rng, 0.2, 1.5);  // σ²κ/d
    return {distance, sigma, random_unit<space_dim<A>>(rng), shift * distance / (sigma * sigma)};
  }
};

}  // namespace holdfast::testing

HOLDFAST_CONFORMS(OnSomePairs<RangeBearingBall>);
