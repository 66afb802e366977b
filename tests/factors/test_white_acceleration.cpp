#include <gtest/gtest.h>

#include <holdfast/factors/white_acceleration.hpp>
#include <holdfast/testing.hpp>

#include "tests/conforms.hpp"
#include "tests/factors/marginal.hpp"

namespace holdfast {
namespace {

using testing::covariance;
using testing::random_covariance;
using testing::random_variable;
using Motion = WhiteAcceleration<Motion2>;
using Square = Matrix<4, 4>;

TEST(WhiteAcceleration, IsZeroForConstantVelocity) {
  const auto factor = Motion::exact(0.5, 4, Square::Identity());
  EXPECT_DOUBLE_EQ(factor.duration(), 2);
  EXPECT_LT(factor(Motion2(1, 3, 2, -1), Motion2(7, 3, 0, -1)).norm(), 1e-14);
}

TEST(WhiteAcceleration, CountsInSigmasOfOneStep) {
  // dt = 2: G = diag(2, 2) per axis, so with R = I every component has sigma 2.
  const auto factor = Motion::exact(2, 1, Square::Identity());
  EXPECT_TRUE(factor(Motion2(0, 1, 0, 0), Motion2(0, 0, 0, 0)).isApprox(Vector<4>(1, 0.5, 0, 0), 1e-14));
}

TEST(WhiteAcceleration, FiveStepsAsMeasuredInTheNotes) {  // notes D.A.1, dt = .05, R = I
  const Square exact = covariance<4>(Motion::exact(0.05, 5, Square::Identity()).sqrt_information);
  EXPECT_NEAR(exact(0, 0), 1.953125e-4, 1e-12);
  EXPECT_NEAR(exact(0, 1), 1.25e-3, 1e-11);
  EXPECT_NEAR(exact(1, 1), 0.0125, 1e-11);
  EXPECT_NEAR(exact(0, 2), 0, 1e-13);
  const Square paper = covariance<4>(Motion::paper(0.05, 5, Square::Identity()).sqrt_information);
  EXPECT_NEAR(paper(1, 1), 0.0625, 1e-10);
  EXPECT_NEAR(paper(0, 0), 9.765625e-4, 1e-12);
  EXPECT_NEAR(paper(0, 1), 0, 1e-12);
}

TEST(WhiteAcceleration, ContinuousNoiseIsASemigroup) {  // Q(T1 + T2) = F(T2) Q(T1) F(T2)ᵀ + Q(T2)
  const auto Q = [](double T) { return covariance<4>(Motion::continuous(T, 0.3).sqrt_information); };
  const Square F = transition<Motion2>(1.7);
  EXPECT_TRUE(Q(2.9).isApprox(F * Q(1.2) * F.transpose() + Q(1.7), 1e-11));
}

TEST(WhiteAcceleration, ExactTendsToContinuousForShortSteps) {
  // Of w only the velocity part survives dt → 0: variance R dt² a step, i.e. q = R dt.
  const Square exact = covariance<4>(Motion::exact(1e-3, 1000, Square::Identity()).sqrt_information);
  const Square continuous = covariance<4>(Motion::continuous(1, 1e-3).sqrt_information);
  EXPECT_TRUE(exact.isApprox(continuous, 5e-3));
}

TEST(WhiteAcceleration, MergedIsTheMarginalOfTheChain) {
  std::mt19937_64 rng(1);
  const auto x = random_variable<Motion2>(rng);
  for (const auto& factor :
       {Motion::exact(0.8, 1, random_covariance<4>(rng)), Motion::exact(0.6, 2, random_covariance<4>(rng)), Motion::continuous(0.9, 0.7)}) {
    for (const int m : {1, 2, 5}) {
      const Eigen::MatrixXd ends = testing::information_of_ends(factor, x, m);
      EXPECT_LT((testing::information(factor.merged(m), x) - ends).norm(), 1e-12 * testing::information(factor, x).norm()) << m;
    }
  }
}

TEST(WhiteAcceleration, PaperAndExactAgreeOnOneStepOnly) {
  std::mt19937_64 rng(2);
  const Square R = random_covariance<4>(rng);
  EXPECT_TRUE(Motion::paper(0.3, 1, R).sqrt_information.isApprox(Motion::exact(0.3, 1, R).sqrt_information, 1e-12));
  EXPECT_FALSE(Motion::paper(0.3, 2, R).sqrt_information.isApprox(Motion::exact(0.3, 2, R).sqrt_information, 1e-2));
  EXPECT_TRUE(Motion::paper(0.3, 2, R).merged(3).sqrt_information.isApprox(Motion::paper(0.3, 6, R).sqrt_information));
}

TEST(WhiteAcceleration, RecursionIsTheKalmanFilters) {
  std::mt19937_64 rng(3);
  const Square R = random_covariance<4>(rng), P = random_covariance<4>(rng);
  const Matrix<2, 2> Q = random_covariance<2>(rng);
  CovarianceRecursion<Motion2> recursion{P};
  const auto factor = recursion.step(0.5, 3, R, Q);
  const Square F = transition<Motion2>(1.5);
  const Square noise = covariance<4>(Motion::paper(0.5, 3, R).sqrt_information);
  const Square predicted = F * P * F.transpose() + noise;
  EXPECT_TRUE(covariance<4>(factor.sqrt_information).isApprox(predicted, 1e-11));
  const Matrix<2, 4> C = Motion2::position_jacobian();
  const Square updated = predicted - predicted * C.transpose() * (C * predicted * C.transpose() + Q).inverse() * C * predicted;
  EXPECT_TRUE(recursion.P.isApprox(updated, 1e-11));
  EXPECT_THROW(factor.merged(2), BadOption);
}

TEST(WhiteAcceleration, WhitensByTheSymmetricRoot) {
  std::mt19937_64 rng(4);
  const auto factor = WhiteAcceleration<Motion3>::exact(0.5, 3, random_covariance<6>(rng));
  EXPECT_TRUE(factor.sqrt_information.isApprox(factor.sqrt_information.transpose(), 1e-13));
  EXPECT_LT(testing::jacobian_error(factor, random_variable<Motion3>(rng), random_variable<Motion3>(rng)), 1e-9);
}

TEST(WhiteAcceleration, RefusesNumbersThatAreNone) {
  const Square R = Square::Identity();
  EXPECT_THROW(Motion::exact(0, 1, R), BadNumber);
  EXPECT_THROW(Motion::exact(NAN, 1, R), BadNumber);
  EXPECT_THROW(Motion::exact(1, 0, R), BadNumber);
  EXPECT_THROW(Motion::exact(1, 1, -R), BadNumber);
  EXPECT_THROW(Motion::paper(1, 1, Square::Zero()), BadNumber);
  EXPECT_THROW(Motion::continuous(1, 0), BadNumber);
  EXPECT_THROW(Motion::continuous(INFINITY, 1), BadNumber);
  EXPECT_THROW(Motion::exact(1, 1, R).merged(0), BadNumber);
  auto spoilt = Motion::exact(1, 1, R);
  spoilt.sqrt_information(0, 0) = NAN;
  EXPECT_THROW(spoilt.validate(), BadNumber);
}

}  // namespace
}  // namespace holdfast

namespace holdfast::testing {

template <class V>
struct Sample<WhiteAcceleration<V>> : RandomVariables<WhiteAcceleration<V>> {
  static WhiteAcceleration<V> factor(std::mt19937_64& rng) {
    using F = WhiteAcceleration<V>;
    const double dt = uniform(rng, 0.2, 1);
    const int steps = static_cast<int>(uniform(rng, 1, 6));
    const Matrix<V::dim, V::dim> R = random_covariance<V::dim>(rng);
    const int kind = static_cast<int>(uniform(rng, 0, 4));
    if (kind == 0) return F::continuous(dt, uniform(rng, 0.1, 2));
    if (kind == 1) return F::paper(dt, steps, R);
    if (kind == 2) return F::recursive(dt, steps, R, random_covariance<V::dim>(rng));
    return F::exact(dt, steps, R);
  }
};

}  // namespace holdfast::testing

HOLDFAST_CONFORMS(WhiteAcceleration<Motion2>, WhiteAcceleration<Motion3>);
