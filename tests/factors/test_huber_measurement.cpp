#include <gtest/gtest.h>

#include <holdfast/factors/huber_measurement.hpp>
#include <holdfast/testing.hpp>

#include "tests/conforms.hpp"

namespace holdfast {
namespace {

using testing::jacobian_error;
using testing::random_covariance;
using testing::random_variable;
using testing::random_vector;

TEST(HuberMeasurement, OfAPositionIsZeroForATrueMeasurement) {
  // An agent at (10, 20) sees a target at (13, 16): z = p_agent − p_target = (−3, 4).
  const Motion2 target(13, 1, 16, 1);
  const auto factor = HuberMeasurement<Motion2>::of_position({-3, 4}, {10, 20}, Matrix<2, 2>::Identity());
  EXPECT_LT(factor(target).norm(), 1e-15);
  const auto off = HuberMeasurement<Motion2>::of_position({-1, 1}, {10, 20}, Vector<2>(4, 9).asDiagonal());
  EXPECT_TRUE(off(target).isApprox(Vector<2>(1, -1), 1e-14));
}

TEST(HuberMeasurement, WhitensByTheSymmetricRoot) {
  std::mt19937_64 rng(1);
  const Matrix<2, 2> Q = random_covariance<2>(rng);
  const auto factor = HuberMeasurement<Point2>::of_position({1, 0}, {0, 0}, Q);
  const Vector<2> r = factor(Point2(0, 0)), z(1, 0);
  EXPECT_NEAR(r.squaredNorm(), z.dot(Q.inverse() * z), 1e-12);
  EXPECT_TRUE(factor.sqrt_information.isApprox(factor.sqrt_information.transpose(), 1e-14));
}

TEST(HuberMeasurement, OfBothNodesAgreesWithEitherNodeKnown) {
  std::mt19937_64 rng(2);
  const Matrix<2, 2> Q = random_covariance<2>(rng);
  const Vector<2> z = random_vector<2>(rng);
  const auto s = random_variable<Motion2>(rng), e = random_variable<Motion2>(rng);
  const Matrix<2, 4> C = Motion2::position_jacobian();
  const auto both = HuberMeasurementEdge<Motion2, Motion2>::of_position(z, Q);
  EXPECT_TRUE((HuberMeasurement<Motion2>::known_start(z, C * s.value, C, Q)(e)).isApprox(both(s, e), 1e-12));
  EXPECT_TRUE((HuberMeasurement<Motion2>::known_end(z, C, C * e.value, Q)(s)).isApprox(both(s, e), 1e-12));
}

TEST(HuberMeasurement, JacobiansAreExact) {
  std::mt19937_64 rng(3);
  const auto one = HuberMeasurement<Motion2>::of_position({1, 2}, {3, 4}, random_covariance<2>(rng));
  EXPECT_LT(jacobian_error(one, random_variable<Motion2>(rng)), 1e-10);
  const auto both = HuberMeasurementEdge<Point3, Motion3>::of_position({1, 2, 3}, random_covariance<3>(rng));
  EXPECT_LT(jacobian_error(both, random_variable<Point3>(rng), random_variable<Motion3>(rng)), 1e-10);
}

TEST(HuberMeasurement, IsScoredAsInPaperA) {
  const auto factor = HuberMeasurement<Point2>::of_position({0, 0}, {0, 0}, Matrix<2, 2>::Identity(), 0.25);
  EXPECT_EQ(factor.default_weight(), 0.25);
  EXPECT_EQ(factor.default_loss(), per_component(Huber{2}));
  EXPECT_LT((factor(Point2(8, 6)) - Vector<2>(8, 6)).norm(), 1e-14);  // the weight does not whiten
}

TEST(HuberMeasurement, RefusesNumbersThatAreNone) {
  const Matrix<2, 2> Q = Matrix<2, 2>::Identity();
  EXPECT_THROW(HuberMeasurement<Point2>::of_position({0, 0}, {0, 0}, -Q), BadNumber);
  EXPECT_THROW(HuberMeasurement<Point2>::of_position({NAN, 0}, {0, 0}, Q).validate(), BadNumber);
  EXPECT_THROW(HuberMeasurement<Point2>::of_position({0, 0}, {INFINITY, 0}, Q).validate(), BadNumber);
  EXPECT_THROW(HuberMeasurement<Point2>::of_position({0, 0}, {0, 0}, Q, 0).validate(), BadNumber);
  EXPECT_THROW((HuberMeasurementEdge<Point2, Point2>::of_position({0, NAN}, Q)).validate(), BadNumber);
  EXPECT_THROW((HuberMeasurementEdge<Point2, Point2>::of_position({0, 0}, Q, -1)).validate(), BadNumber);
}

}  // namespace
}  // namespace holdfast

namespace holdfast::testing {

template <class V, int Rows>
struct Sample<HuberMeasurement<V, Rows>> : RandomVariables<HuberMeasurement<V, Rows>> {
  static HuberMeasurement<V, Rows> factor(std::mt19937_64& rng) {
    using F = HuberMeasurement<V, Rows>;
    const Vector<Rows> z = random_vector<Rows>(rng, 5), known = random_vector<Rows>(rng, 5);
    const Matrix<Rows, Rows> Q = random_covariance<Rows>(rng);
    const double weight = uniform(rng, 0.3, 2);
    if constexpr (Rows == V::space_dim)
      return F::of_position(z, known, Q, weight);
    else
      return F::known_end(z, Matrix<Rows, V::dim>::Identity(), known, Q, weight);
  }
};

template <class S, class E, int Rows>
struct Sample<HuberMeasurementEdge<S, E, Rows>> : RandomVariables<HuberMeasurementEdge<S, E, Rows>> {
  static HuberMeasurementEdge<S, E, Rows> factor(std::mt19937_64& rng) {
    const Vector<Rows> z = random_vector<Rows>(rng, 5);
    const Matrix<Rows, Rows> Q = random_covariance<Rows>(rng);
    return HuberMeasurementEdge<S, E, Rows>::of_position(z, Q, uniform(rng, 0.3, 2));
  }
};

}  // namespace holdfast::testing

HOLDFAST_CONFORMS(HuberMeasurement<Point2>, HuberMeasurement<Motion2>, HuberMeasurement<Accel2>, HuberMeasurement<Point3>,
                  HuberMeasurement<Motion3>, HuberMeasurement<Motion2, 4>, HuberMeasurementEdge<Motion2, Motion2>,
                  HuberMeasurementEdge<Point2, Motion2>, HuberMeasurementEdge<Point3, Motion3>);
