#include <gtest/gtest.h>

#include <holdfast/factors/bearing_ray.hpp>
#include <holdfast/factors/von_mises_bearing.hpp>
#include <holdfast/graph/variables.hpp>
#include <holdfast/testing.hpp>

#include "tests/conforms.hpp"

namespace holdfast {
namespace {

using Ray = BearingRay<Point2, Point2>;

const Point2 kOrigin(0, 0);

TEST(BearingRay, IsTheWayToTheRayInSigmas) {
  const Ray ray{{1, 0}, 0.5};
  EXPECT_TRUE(ray(kOrigin, Point2(7, 3)).isApprox(Vector<2>(0, 6)));
  EXPECT_TRUE(ray(kOrigin, Point2(-4, 3)).isApprox(Vector<2>(-8, 6)));  // behind: the nearest point is the origin
  EXPECT_TRUE(ray(kOrigin, Point2(9, 0)).isZero(0));
}

TEST(BearingRay, JacobianIsExactOnBothSides) {
  std::mt19937_64 rng(1);
  for (int i = 0; i < 10; ++i) {
    const BearingRay<Pose3, Motion3> ray{testing::random_unit<3>(rng), 0.5};
    EXPECT_LT(testing::jacobian_error(ray, testing::random_variable<Pose3>(rng), testing::random_variable<Motion3>(rng)), 1e-8);
  }
}

TEST(BearingRay, CostIsConvex) {
  std::mt19937_64 rng(2);
  const auto cost = [](const Ray& ray, const Vector<2>& x) { return ray(kOrigin, Point2(x)).squaredNorm(); };
  for (int draw = 0; draw < 300; ++draw) {
    const Ray ray{testing::random_unit<2>(rng), 0.5};
    const Vector<2> x = testing::random_vector<2>(rng, 5), y = testing::random_vector<2>(rng, 5);
    EXPECT_LE(cost(ray, (x + y) / 2), (cost(ray, x) + cost(ray, y)) / 2 * (1 + 1e-12) + 1e-12);
  }
}

TEST(BearingRay, IsWhatABearingIsRelaxedTo) {
  const VonMisesBearing<Point2, Point2> bearing{{1, 0}, 400};
  const Point2 aside(1, 0.01);  // 0.01 rad at one metre: 0.2 sigma for both
  EXPECT_NEAR(bearing(kOrigin, aside).norm(), 0.2, 1e-5);
  EXPECT_NEAR(bearing.relaxed()(kOrigin, aside).norm(), 0.2, 1e-12);
}

TEST(BearingRay, RefusesNumbersThatAreNone) {
  EXPECT_THROW((Ray{{1, 1}, 1}).validate(), BadNumber);
  EXPECT_THROW((Ray{{1, 0}, 0}).validate(), BadNumber);
}

TEST(BearingRay, RawIsTheWayToTheRayInMetres) {
  const Ray ray{{1, 0}, 0.5};
  EXPECT_TRUE(ray.raw(ray(kOrigin, Point2(7, 3))).isApprox(Vector<2>(0, 3)));
}

}  // namespace
}  // namespace holdfast

HOLDFAST_CONFORMS(OnSomePairs<BearingRay>);
