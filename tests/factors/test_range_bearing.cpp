#include <gtest/gtest.h>

#include <holdfast/factors/range_bearing.hpp>
#include <holdfast/graph/variables.hpp>
#include <holdfast/testing.hpp>

#include "tests/conforms.hpp"

namespace holdfast {
namespace {

using testing::random_unit;
using testing::uniform;
using Packet = RangeBearing<Point2, Point2>;

TEST(RangeBearing, IsARangeAndABearing) {
  const Packet packet{4, 0.5, {1, 0}, 100};
  const Vector<3> r = packet(Point2(1, 1), Point2(4, 5));  // 5 m away, along (0.6, 0.8)
  EXPECT_TRUE(r.isApprox(Vector<3>(2, 4, -8), 1e-14));
}

TEST(RangeBearing, JacobianIsExact) {
  std::mt19937_64 rng(1);
  for (int i = 0; i < 10; ++i) {
    const RangeBearing<Pose3, Motion3> packet{4, 0.5, random_unit<3>(rng), 10};
    EXPECT_LT(testing::jacobian_error(packet, testing::random_variable<Pose3>(rng), testing::random_variable<Motion3>(rng)), 1e-8);
  }
}

TEST(RangeBearing, IsRelaxedToALowerBound) {
  std::mt19937_64 rng(2);
  for (int i = 0; i < 300; ++i) {
    const Packet packet{uniform(rng, 1, 5), uniform(rng, 0.3, 1), random_unit<2>(rng), uniform(rng, 1, 20)};
    const Point2 there((packet.distance * uniform(rng, 0.01, 3) * random_unit<2>(rng)).eval());
    EXPECT_LE(packet.relaxed()(Point2(0, 0), there).squaredNorm(), packet(Point2(0, 0), there).squaredNorm() * (1 + 1e-12));
  }
  const Packet packet{5, 0.5, {0.6, 0.8}, 10};
  EXPECT_LT(packet.relaxed()(Point2(0, 0), Point2(3, 4)).norm(), 1e-14);  // both are zero at the measured point
}

TEST(RangeBearing, RefusesNumbersThatAreNone) {
  EXPECT_THROW((Packet{0, 1, {1, 0}, 1}).validate(), BadNumber);
  EXPECT_THROW((Packet{1, 0, {1, 0}, 1}).validate(), BadNumber);
  EXPECT_THROW((Packet{1, 1, {1, 1}, 1}).validate(), BadNumber);
  EXPECT_THROW((Packet{1, 1, {1, 0}, -1}).validate(), BadNumber);
}

}  // namespace
}  // namespace holdfast

namespace holdfast::testing {

template <class A, class B>
struct Sample<RangeBearing<A, B>> : RandomVariables<RangeBearing<A, B>> {
  static RangeBearing<A, B> factor(std::mt19937_64& rng) {
    return {uniform(rng, 1, 30), uniform(rng, 0.5, 2), random_unit<space_dim<A>>(rng), uniform(rng, 1, 100)};
  }
};

}  // namespace holdfast::testing

HOLDFAST_CONFORMS(OnSomePairs<RangeBearing>);
