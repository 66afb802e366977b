#include <gtest/gtest.h>

#include <holdfast/factors/prior.hpp>
#include <holdfast/testing.hpp>

#include "tests/conforms.hpp"

namespace holdfast {
namespace {

using testing::jacobian_error;
using testing::random_covariance;
using testing::random_variable;

TEST(Prior, MeasuresInSigmas) {
  const auto prior = Prior<Motion2>::from_sigmas(Motion2(1, 2, 3, 4), {1, 2, 4, 8});
  EXPECT_TRUE(prior(Motion2(2, 4, 7, 12)).isApprox(Vector<4>::Ones(), 1e-15));
}

TEST(Prior, OfAPoseTurnsTheShortWay) {
  const auto prior = Prior<Pose2>::from_sigmas(Pose2(0, 0, 3.1), {1, 1, 0.1});
  EXPECT_NEAR(prior(Pose2(0, 0, -3.1))[2], (2 * kPi - 6.2) / 0.1, 1e-12);
}

TEST(Prior, OfAPoseInSpaceIsTheFullAngle) {
  const auto prior = Prior<Pose3>::from_sigmas(Pose3(), Vector<6>::Ones());
  const Pose3 x(Vector<3>(1, 2, 3), so3::exp<double>(Vector<3>(0, 0, kPi / 2)));
  EXPECT_TRUE(prior(x).isApprox((Vector<6>() << 1, 2, 3, 0, 0, kPi / 2).finished(), 1e-15));
}

TEST(Prior, JacobianIsExactNearAndFarFromTheMean) {
  std::mt19937_64 rng(1);
  for (int i = 0; i < 20; ++i) {
    const auto mean = random_variable<Pose3>(rng);
    const auto prior = Prior<Pose3>::from_covariance(mean, random_covariance<6>(rng));
    EXPECT_LT(jacobian_error(prior, mean), 1e-9);
    EXPECT_LT(jacobian_error(prior, mean.retract(testing::random_vector<6>(rng, 1e-8))), 1e-9);
    EXPECT_LT(jacobian_error(prior, mean.retract(testing::random_vector<6>(rng, 1e-3))), 1e-9);
    EXPECT_LT(jacobian_error(prior, mean.retract(testing::random_vector<6>(rng, 0.5))), 1e-9);
  }
}

TEST(Prior, RefusesNumbersThatAreNone) {
  EXPECT_THROW((Prior<Scalar>{Scalar(std::nan("")), Matrix<1, 1>(1.0)}).validate(), BadNumber);
  EXPECT_THROW((Prior<Scalar>{Scalar(0), Matrix<1, 1>(INFINITY)}).validate(), BadNumber);
  EXPECT_THROW(Prior<Point2>::from_sigmas(Point2(0, 0), {1, 0}), BadNumber);
  EXPECT_THROW(Prior<Point2>::from_covariance(Point2(0, 0), Matrix<2, 2>::Ones()), BadNumber);
  EXPECT_NO_THROW((Prior<Scalar>{Scalar(1), Matrix<1, 1>(0.0)}).validate());  // no information is a number
}

/// A user's own manifold: a positive scale, x ⊕ δ = x exp(δ). Without a local_jacobian of its own it gets one by dual numbers.
template <class T>
struct ScaleT {
  static constexpr int dim = 1;
  template <class U>
  using rebind = ScaleT<U>;
  T value{1};
  static const char* name() { return "Scale"; }
  template <class U>
  ScaleT<U> cast() const {
    return {U(value)};
  }
  ScaleT retract(const VectorT<T, 1>& delta) const {
    using std::exp;
    return {value * exp(delta[0])};
  }
  VectorT<T, 1> local(const ScaleT& other) const {
    using std::sqrt;  // not the logarithm: a chart whose derivative is not 1 away from the mean
    return VectorT<T, 1>(T(2) * (sqrt(other.value / value) - T(1)));
  }
  bool is_finite() const { return std::isfinite(value); }
};

TEST(Prior, OfAUsersOwnManifoldHasItsJacobian) {
  using Scale = ScaleT<double>;
  const auto prior = Prior<Scale>::from_sigmas(Scale{4}, Vector<1>(0.5));
  EXPECT_NEAR(prior(Scale{9})[0], 2, 1e-15);  // 2 (√(9/4) − 1) / 0.5
  Jacobians<Prior<Scale>> J;
  prior(Scale{9}, &J);
  EXPECT_NEAR(J.all(0, 0), 3, 1e-14);  // √(9/4) / 0.5
  EXPECT_LT(jacobian_error(prior, Scale{9}), 1e-9);
}

}  // namespace
}  // namespace holdfast

namespace holdfast::testing {

template <class V>
struct Sample<Prior<V>> : RandomVariables<Prior<V>> {
  static Prior<V> factor(std::mt19937_64& rng) {
    const V mean = near_rotation(V{}, 1, rng);
    return Prior<V>::from_information(mean, random_information<V::dim>(rng));
  }
};

}  // namespace holdfast::testing

HOLDFAST_CONFORMS(OnAll<Prior>);
