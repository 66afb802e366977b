#include <gtest/gtest.h>

#include <holdfast/factors/white_jerk.hpp>
#include <holdfast/testing.hpp>

#include "tests/conforms.hpp"
#include "tests/factors/marginal.hpp"

namespace holdfast {
namespace {

using testing::covariance;
using testing::random_variable;
using Motion = WhiteJerk<Accel2>;

TEST(WhiteJerk, IsZeroForConstantAcceleration) {
  // p = 1 + 2t + 1.5t², after 2 s.
  EXPECT_LT(Motion::continuous(2, 0.1)(Accel2(1, 2, 3, 0, 0, 0), Accel2(11, 8, 3, 0, 0, 0)).norm(), 1e-13);
}

TEST(WhiteJerk, NoiseOfOneSecond) {
  const Matrix<6, 6> Q = covariance<6>(Motion::continuous(1, 120).sqrt_information);
  Matrix<3, 3> axis;
  axis << 6, 15, 20, 15, 40, 60, 20, 60, 120;
  EXPECT_TRUE((Q.topLeftCorner<3, 3>()).isApprox(axis, 1e-10));
  EXPECT_TRUE((Q.bottomRightCorner<3, 3>()).isApprox(axis, 1e-10));
  EXPECT_LT((Q.topRightCorner<3, 3>()).norm(), 1e-9);
}

TEST(WhiteJerk, ContinuousNoiseIsASemigroup) {
  const auto Q = [](double T) { return covariance<6>(Motion::continuous(T, 0.3).sqrt_information); };
  const Matrix<6, 6> F = transition<Accel2>(1.7);
  EXPECT_TRUE(Q(2.9).isApprox(F * Q(1.2) * F.transpose() + Q(1.7), 1e-10));
}

TEST(WhiteJerk, MergedIsTheMarginalOfTheChain) {
  std::mt19937_64 rng(1);
  const auto x = random_variable<Accel2>(rng);
  const auto factor = Motion::continuous(0.9, 0.7);
  for (const int m : {1, 2, 5}) {
    const Eigen::MatrixXd ends = testing::information_of_ends(factor, x, m);
    EXPECT_LT((testing::information(factor.merged(m), x) - ends).norm(), 1e-12 * testing::information(factor, x).norm()) << m;
  }
}

TEST(WhiteJerk, WhitensOverTheShortestTimes) {
  const double T = 1e-4;
  const Matrix<6, 6> W = Motion::continuous(T, 1).sqrt_information;
  // The triangular root conditions from the back: the last component is the acceleration alone, of variance T.
  EXPECT_NEAR(W(2, 2) * std::sqrt(T), 1, 1e-12);
  // The first is the position given velocity and acceleration, of variance T⁵/720.
  EXPECT_NEAR(W(0, 0) * std::sqrt(std::pow(T, 5) / 720), 1, 1e-9);
}

TEST(WhiteJerk, JacobianIsExact) {
  std::mt19937_64 rng(2);
  EXPECT_LT(testing::jacobian_error(WhiteJerk<Accel3>::continuous(1.3, 0.4), random_variable<Accel3>(rng), random_variable<Accel3>(rng)),
            1e-9);
}

TEST(WhiteJerk, RefusesNumbersThatAreNone) {
  EXPECT_THROW(Motion::continuous(0, 1), BadNumber);
  EXPECT_THROW(Motion::continuous(1, -1), BadNumber);
  EXPECT_THROW(Motion::continuous(NAN, 1), BadNumber);
  EXPECT_THROW(Motion::continuous(1, 1).merged(0), BadNumber);
  EXPECT_THROW((Motion{1, 1, Matrix<6, 6>::Constant(NAN)}).validate(), BadNumber);
}

}  // namespace
}  // namespace holdfast

namespace holdfast::testing {

template <class V>
struct Sample<WhiteJerk<V>> : RandomVariables<WhiteJerk<V>> {
  static WhiteJerk<V> factor(std::mt19937_64& rng) {
    const double duration = uniform(rng, 0.5, 2);
    return WhiteJerk<V>::continuous(duration, uniform(rng, 0.1, 2));
  }
};

}  // namespace holdfast::testing

HOLDFAST_CONFORMS(WhiteJerk<Accel2>, WhiteJerk<Accel3>);
