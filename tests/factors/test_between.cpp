#include <gtest/gtest.h>

#include <holdfast/factors/between.hpp>
#include <holdfast/testing.hpp>

#include "tests/conforms.hpp"

namespace holdfast {
namespace {

using testing::jacobian_error;
using testing::random_covariance;
using testing::random_variable;
using testing::random_vector;

TEST(Between, IsZeroForATrueMeasurement) {
  std::mt19937_64 rng(1);
  for (int i = 0; i < 20; ++i) {
    const auto a2 = random_variable<Pose2>(rng), z2 = random_variable<Pose2>(rng);
    EXPECT_LT(Between<Pose2>::from_sigmas(z2, {1, 1, 1})(a2, a2 * z2).norm(), 1e-13);
    const auto a3 = random_variable<Pose3>(rng), z3 = random_variable<Pose3>(rng);
    EXPECT_LT(Between<Pose3>::from_sigmas(z3, Vector<6>::Ones())(a3, a3 * z3).norm(), 1e-13);
  }
}

TEST(Between, OfPosesIsInTheFrameOfTheMeasuredPose) {
  // a looks north from the origin, b was said to be 1 m ahead and looking left (west); it is 2 m further and looks south.
  const auto factor = Between<Pose2>::from_sigmas(Pose2(1, 0, kPi / 2), {1, 1, 0.5});
  const Vector<3> r = factor(Pose2(0, 0, kPi / 2), Pose2(0, 3, -kPi / 2));
  EXPECT_TRUE(r.isApprox(Vector<3>(0, -2, kPi), 1e-15)) << r.transpose();
}

TEST(Between, OfPosesInSpaceIsTheErrorOfTheChain) {
  std::mt19937_64 rng(2);
  for (int i = 0; i < 20; ++i) {
    const auto a = random_variable<Pose3>(rng), b = random_variable<Pose3>(rng), z = random_variable<Pose3>(rng);
    const Pose3 error = z.inverse() * a.inverse() * b;
    Vector<6> expected;
    expected << error.p, so3::log<double>(error.q);
    EXPECT_TRUE(Between<Pose3>::from_sigmas(z, Vector<6>::Ones())(a, b).isApprox(expected, 1e-12));
  }
}

TEST(Between, JacobianIsExactAwayFromTheOptimum) {
  std::mt19937_64 rng(3);
  for (int i = 0; i < 20; ++i) {
    for (const double error : {0.0, 1e-8, 1e-3, 0.5}) {
      const auto a2 = random_variable<Pose2>(rng), z2 = random_variable<Pose2>(rng);
      EXPECT_LT(jacobian_error(Between<Pose2>::from_covariance(z2, random_covariance<3>(rng)), a2,
                               (a2 * z2).retract(random_vector<3>(rng, error))),
                1e-9);
      const auto a3 = random_variable<Pose3>(rng), z3 = random_variable<Pose3>(rng);
      EXPECT_LT(jacobian_error(Between<Pose3>::from_covariance(z3, random_covariance<6>(rng)), a3,
                               (a3 * z3).retract(random_vector<6>(rng, error))),
                1e-9);
    }
  }
}

TEST(Between, JacobianIsExactAtTheIdentity) {
  EXPECT_LT(jacobian_error(Between<Pose2>::from_sigmas(Pose2(), {1, 2, 3}), Pose2(), Pose2()), 1e-10);
  EXPECT_LT(jacobian_error(Between<Pose3>::from_sigmas(Pose3(), Vector<6>::Ones()), Pose3(), Pose3()), 1e-10);
}

TEST(Between, OfPosesDoesNotChangeWhenTheWorldMoves) {
  std::mt19937_64 rng(4);
  const auto world = random_variable<Pose3>(rng), a = random_variable<Pose3>(rng), b = random_variable<Pose3>(rng);
  const auto factor = Between<Pose3>::from_covariance(random_variable<Pose3>(rng), random_covariance<6>(rng));
  EXPECT_TRUE(factor(world * a, world * b).isApprox(factor(a, b), 1e-10));
}

TEST(Between, OfVectorSpacesIsTheDifference) {
  const auto factor = Between<Point2>::from_sigmas(Point2(1, 1), {0.5, 2});
  EXPECT_TRUE(factor(Point2(1, 2), Point2(3, 7)).isApprox(Vector<2>(2, 2)));
  EXPECT_LT(jacobian_error(factor, Point2(1, 2), Point2(3, 7)), 1e-10);
  const auto scalar = Between<Scalar>::from_sigmas(Scalar(2), Vector<1>(0.5));
  EXPECT_DOUBLE_EQ(scalar(Scalar(1), Scalar(4))[0], 2);
}

TEST(Between, RefusesNumbersThatAreNone) {
  EXPECT_THROW((Between<Pose2>{Pose2(NAN, 0, 0), Matrix<3, 3>::Identity()}).validate(), BadNumber);
  EXPECT_THROW((Between<Pose2>{Pose2(), Matrix<3, 3>::Constant(INFINITY)}).validate(), BadNumber);
  EXPECT_THROW(Between<Pose2>::from_information(Pose2(), -Matrix<3, 3>::Identity()), BadNumber);
}

}  // namespace
}  // namespace holdfast

namespace holdfast::testing {

template <class V>
struct Sample<Between<V>> : RandomVariables<Between<V>> {
  static Between<V> factor(std::mt19937_64& rng) {
    const V measured = near_rotation(V{}, 1, rng);
    return Between<V>::from_information(measured, random_information<V::dim>(rng));
  }
};

}  // namespace holdfast::testing

HOLDFAST_CONFORMS(OnAll<Between>);
