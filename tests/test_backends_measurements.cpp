// Numbers that no factor may hold: sigmas that are not positive, covariances that are not positive definite. (NaN and infinity in any
// field: tests/factors/test_every_factor.cpp.)
#include <gtest/gtest.h>

#include <holdfast/factors/missing_distance.hpp>
#include <holdfast/factors/range_bearing_ball.hpp>

#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

constexpr double kBadSigmas[] = {0, -1, NAN, INFINITY};
constexpr Agent A('A'), B('B');

TEST(Measurements, SigmasArePositive) {
  using Pair = std::array<Key, 2>;
  const Pair keys{A(0), B(0)};
  for (const double sigma : kBadSigmas) {
    SCOPED_TRACE(sigma);
    Graph graph;
    EXPECT_THROW(graph.add(Range<Point2, Point2>{1, sigma}, keys), BadNumber);
    EXPECT_THROW(graph.add(RangeBall<Point2, Point2>{1, sigma}, keys), BadNumber);
    EXPECT_THROW(graph.add(PositionStep<Point2, Point2>{sigma}, keys), BadNumber);
    EXPECT_THROW(graph.add(MissingDistance<Point2, Point2>{1, sigma, 1}, keys), BadNumber);
    EXPECT_THROW(graph.add(MissingDistance<Point2, Point2>{1, 1, sigma}, keys), BadNumber);
    EXPECT_THROW(graph.add(MissingDistancePrior{1, sigma}, {A(0)}), BadNumber);
    EXPECT_THROW(graph.add(RangeBearingBall<Point2, Point2>{1, sigma, {1, 0}, 1}, keys), BadNumber);
    EXPECT_THROW(Prior<Point2>::from_sigmas(Point2(0, 0), Vector<2>(1, sigma)), BadNumber);
    EXPECT_THROW(Between<Pose2>::from_sigmas(Pose2(), Vector<3>(1, 1, sigma)), BadNumber);
    EXPECT_EQ(graph.size(), 0u);
  }
}

TEST(Measurements, CovariancesArePositiveDefinite) {
  Matrix<2, 2> indefinite, singular, skew;
  indefinite << 1, 2, 2, 1;
  singular << 1, 1, 1, 1;
  skew << 1, 0.5, -0.5, 1;
  for (const auto& bad : {indefinite, singular, skew, Matrix<2, 2>(Matrix<2, 2>::Zero()), Matrix<2, 2>(-Matrix<2, 2>::Identity()),
                          Matrix<2, 2>(Matrix<2, 2>::Constant(NAN))}) {
    EXPECT_THROW(Prior<Point2>::from_covariance(Point2(0, 0), bad), BadNumber) << bad;
    EXPECT_THROW(HuberMeasurement<Point2>::of_position({0, 0}, {0, 0}, bad), BadNumber) << bad;
    EXPECT_THROW((RelativePoint<Pose2, Point2>::from_covariance({0, 0}, bad)), BadNumber) << bad;
  }
}

TEST(Measurements, InformationIsPositiveSemidefinite) {
  Matrix<2, 2> indefinite, singular, skew;
  indefinite << 1, 2, 2, 1;
  singular << 1, 1, 1, 1;
  skew << 1, 0.5, -0.5, 1;
  for (const auto& bad : {indefinite, skew, Matrix<2, 2>(-Matrix<2, 2>::Identity()), Matrix<2, 2>(Matrix<2, 2>::Constant(NAN))})
    EXPECT_THROW(Prior<Point2>::from_information(Point2(0, 0), bad), BadNumber) << bad;
  const auto of_the_sum = Prior<Point2>::from_information(Point2(0, 0), singular);  // of x + y, and of nothing else
  EXPECT_NEAR(of_the_sum(Point2(3, 1)).squaredNorm(), 16, 1e-12);
  EXPECT_NEAR(of_the_sum(Point2(2, -2)).squaredNorm(), 0, 1e-12);
  EXPECT_EQ(Prior<Point2>::from_information(Point2(0, 0), Matrix<2, 2>::Zero())(Point2(3, 1)).norm(), 0);
}

}  // namespace
}  // namespace holdfast::testing
