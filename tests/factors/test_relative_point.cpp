#include <gtest/gtest.h>

#include <holdfast/factors/relative_point.hpp>
#include <holdfast/graph/variables.hpp>
#include <holdfast/testing.hpp>

#include "tests/conforms.hpp"

namespace holdfast {
namespace {

using testing::jacobian_error;
using testing::random_covariance;
using testing::random_variable;

TEST(RelativePoint, SeesALandmarkInTheBodyFrame) {
  // Looking north from (1, 1), a landmark 3 m north is 3 m ahead, one 2 m west is 2 m to the left.
  const auto ahead = RelativePoint<Pose2, Point2>::from_sigmas({3, 0}, {1, 1});
  EXPECT_LT(ahead(Pose2(1, 1, kPi / 2), Point2(1, 4)).norm(), 1e-15);
  EXPECT_TRUE(ahead(Pose2(1, 1, kPi / 2), Point2(-1, 1)).isApprox(Vector<2>(-3, 2), 1e-15));
}

TEST(RelativePoint, SeesAnotherAgentInSpace) {
  const auto factor = RelativePoint<Pose3, Motion3>::from_sigmas({0, -2, 1}, {1, 1, 0.5});
  const Pose3 yawed(Vector<3>(1, 1, 1), so3::exp<double>(Vector<3>(0, 0, kPi / 2)));  // its y axis points to −x
  EXPECT_TRUE(factor(yawed, Motion3(3, 9, 1, 9, 3, 9)).isApprox(Vector<3>(0, 0, 2), 1e-14));
}

TEST(RelativePoint, JacobianIsExact) {
  std::mt19937_64 rng(1);
  for (int i = 0; i < 10; ++i) {
    const auto in_plane = RelativePoint<Pose2, Point2>::from_covariance({1, 2}, random_covariance<2>(rng));
    EXPECT_LT(jacobian_error(in_plane, random_variable<Pose2>(rng), random_variable<Point2>(rng)), 1e-9);
    EXPECT_LT(jacobian_error(in_plane, testing::near_identity<Pose2>(rng), Point2()), 1e-9);
    const auto in_space = RelativePoint<Pose3, Pose3>::from_covariance({1, 2, 3}, random_covariance<3>(rng));
    EXPECT_LT(jacobian_error(in_space, random_variable<Pose3>(rng), random_variable<Pose3>(rng)), 1e-9);
    EXPECT_LT(jacobian_error(in_space, testing::near_identity<Pose3>(rng), Pose3()), 1e-9);
  }
}

TEST(RelativePoint, RefusesNumbersThatAreNone) {
  using F = RelativePoint<Pose2, Point2>;
  EXPECT_THROW((F{{NAN, 0}, Matrix<2, 2>::Identity()}).validate(), BadNumber);
  EXPECT_THROW((F{{0, 0}, Matrix<2, 2>::Constant(NAN)}).validate(), BadNumber);
  EXPECT_THROW(F::from_sigmas({0, 0}, {0, 1}), BadNumber);
}

}  // namespace
}  // namespace holdfast

namespace holdfast::testing {

template <class P, class L>
struct Sample<RelativePoint<P, L>> : RandomVariables<RelativePoint<P, L>> {
  static RelativePoint<P, L> factor(std::mt19937_64& rng) {
    const Vector<P::space_dim> measured = random_vector<P::space_dim>(rng, 5);
    return RelativePoint<P, L>::from_information(measured, random_information<P::space_dim>(rng));
  }
};

}  // namespace holdfast::testing

HOLDFAST_CONFORMS(OnPoses<RelativePoint>);
