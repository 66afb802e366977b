// Numbers that no factor may hold: NaN and infinity in any field, sigmas that are not positive, covariances that are not positive definite.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/problems.hpp"
#include "tests/samples.hpp"

namespace holdfast::testing {
namespace {

using ::testing::HasSubstr;

/// Where a factor holds something else than a double.
template <class F>
bool is_double(std::size_t) {
  return true;
}
template <>
bool is_double<WhiteAcceleration<Motion2>>(std::size_t i) {
  return i != offsetof(WhiteAcceleration<Motion2>, kind) / sizeof(double) &&
         i != offsetof(WhiteAcceleration<Motion2>, steps) / sizeof(double);
}
template <class F>
typename Graph::Keys<F> some_keys() {
  std::array<Key, F::Variables::size> keys;
  for (std::size_t k = 0; k < keys.size(); ++k) keys[k] = Key(static_cast<char>('P' + k), 3);
  return keys;
}

/// Every double of the struct made NaN, then infinite: add() throws, naming factor and keys, and the graph stays as it was.
template <class F>
void expect_refused() {
  std::mt19937_64 rng(31);
  const F good = Sample<F>::factor(rng);
  for (std::size_t i = 0; i < sizeof(F) / sizeof(double); ++i)
    for (const double bad : {static_cast<double>(NAN), static_cast<double>(INFINITY), -static_cast<double>(INFINITY)}) {
      if (!is_double<F>(i)) continue;
      SCOPED_TRACE(factor_name<F>() + " double " + std::to_string(i) + " = " + std::to_string(bad));
      F factor = good;
      std::memcpy(reinterpret_cast<char*>(&factor) + i * sizeof(double), &bad, sizeof(double));
      Graph graph;
      try {
        graph.add(factor, some_keys<F>());
        ADD_FAILURE() << "it was taken";
      } catch (const BadNumber& error) {
        EXPECT_THAT(error.what(), HasSubstr(factor_name<F>() + "(P3"));
      }
      EXPECT_EQ(graph.size(), 0u);
    }
}

TEST(Measurements, NonFiniteNumbersAreRefusedInEveryField) {
  for_each_type<SomeFactors>([](auto tag) { expect_refused<typename decltype(tag)::type>(); });
}

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
    EXPECT_THROW(Prior<Point2>::from_information(Point2(0, 0), bad), BadNumber) << bad;
    EXPECT_THROW(HuberMeasurement<Point2>::of_position({0, 0}, {0, 0}, bad), BadNumber) << bad;
    EXPECT_THROW((RelativePoint<Pose2, Point2>::from_covariance({0, 0}, bad)), BadNumber) << bad;
  }
}

}  // namespace
}  // namespace holdfast::testing
