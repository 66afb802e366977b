// hessian() of a factor is the second derivative of ½‖r‖² along the tangents, positive semidefinite where the factor is convex.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "tests/samples.hpp"

namespace holdfast::testing {
namespace {

template <class F>
using Hessian = Matrix<F::Variables::total_dim, F::Variables::total_dim>;
template <class F>
using Step = Vector<F::Variables::total_dim>;

template <class F, std::size_t... I>
double half_square(const F& factor, const typename F::Variables::Tuple& x, const Step<F>& delta, std::index_sequence<I...>) {
  using Vars = typename F::Variables;
  return 0.5 * factor(std::get<I>(x).retract(delta.template segment<Vars::dims[I]>(Vars::offsets[I]))...).squaredNorm();
}
template <class F>
double half_square(const F& factor, const typename F::Variables::Tuple& x, const Step<F>& delta) {
  return half_square(factor, x, delta, std::make_index_sequence<F::Variables::size>{});
}

/// By second differences over two steps, extrapolated.
template <class F>
Hessian<F> numeric_hessian(const F& factor, const typename F::Variables::Tuple& x) {
  const auto difference = [&](int i, int j, double h) {
    const Step<F> a = h * Step<F>::Unit(i), b = h * Step<F>::Unit(j);
    const auto f = [&](const Step<F>& delta) { return half_square(factor, x, delta); };
    return (f(a + b) - f(a - b) - f(b - a) + f(-a - b)) / (4 * h * h);
  };
  constexpr double step = 4e-3;
  Hessian<F> H;
  for (int i = 0; i < H.rows(); ++i)
    for (int j = 0; j < H.rows(); ++j) H(i, j) = (4 * difference(i, j, step / 2) - difference(i, j, step)) / 3;
  return H;
}

template <class F>
Hessian<F> hessian_at(const F& factor, const typename F::Variables::Tuple& x) {
  return std::apply([&](const auto&... v) { return factor.hessian(v...); }, x);
}

template <template <class, class> class F>
using OnHessianPairs = std::tuple<F<Point2, Point2>, F<Pose2, Point2>, F<Accel3, Motion3>, F<Pose3, Pose3>>;
using HessianFactors = Concat<OnHessianPairs<Range>, OnHessianPairs<RangeBall>, OnHessianPairs<RangeBearingBall>,
                              OnHessianPairs<MissingDistance>, OnHessianPairs<MissingDistanceBall>>;

TEST(Hessian, IsTheSecondDerivativeOfHalfTheSquaredResidual) {
  std::mt19937_64 rng(41);
  for_each_type<HessianFactors>([&](auto tag) {
    using F = typename decltype(tag)::type;
    static_assert(holdfast::detail::HasHessian<F>::value);
    for (int i = 0; i < 20; ++i) {
      const F factor = Sample<F>::factor(rng);
      const typename F::Variables::Tuple x = Sample<F>::variables(rng);
      const Hessian<F> H = hessian_at(factor, x), numeric = numeric_hessian(factor, x);
      const double scale = 1 + numeric.cwiseAbs().maxCoeff() + half_square(factor, x, Step<F>::Zero());
      EXPECT_LT((H - numeric).cwiseAbs().maxCoeff(), 1e-8 * scale) << factor_name<F>() << "\n" << H << "\n\n" << numeric;
      EXPECT_LT((H - H.transpose()).cwiseAbs().maxCoeff(), 1e-14 * scale) << factor_name<F>();
      const double least = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(H).eigenvalues()[0];
      if (is_convex<F>) {
        EXPECT_GE(least, -1e-12 * scale) << factor_name<F>();
      }
    }
  });
}

// σ = 0.5, 3 m measured, the points 4 m apart along x: (1 − 3/4)/σ² = 1 across, 1/σ² = 4 along. JᵀJ has (1 − 3/4)²/σ² = 1/4 across.
TEST(Hessian, OfABallByHand) {
  const RangeBall<Point2, Point2> ball{3, 0.5};
  const Matrix<4, 4> outside = ball.hessian({0, 0}, {4, 0});
  EXPECT_TRUE((outside.bottomRightCorner<2, 2>().isApprox(Matrix<2, 2>(Vector<2>(4, 1).asDiagonal()), 1e-15))) << outside;
  EXPECT_TRUE((outside.topRightCorner<2, 2>().isApprox(-Matrix<2, 2>(Vector<2>(4, 1).asDiagonal()), 1e-15))) << outside;
  EXPECT_TRUE(ball.hessian({0, 0}, {2, 0}).isZero(0));
  EXPECT_TRUE(ball.hessian({1, 1}, {1, 1}).isZero(0));
}

// Nearer than measured, the cost of a range falls to both sides.
TEST(Hessian, OfARangeIsIndefiniteWhereThePositionsAreTooNear) {
  const Range<Point2, Point2> range{3, 0.5};
  const Matrix<4, 4> H = range.hessian({0, 0}, {2, 0});
  EXPECT_NEAR(H(2, 2), 4, 1e-14);
  EXPECT_NEAR(H(3, 3), -2, 1e-14);  // (1 − 3/2)/σ²
  EXPECT_TRUE(range.hessian({1, 1}, {1, 1}).isZero(0));
}

// c is linear inside: the distance is measured as 3 m along x, the points are 1 m apart, v = x + σ²κ/d u = (2, 0).
TEST(Hessian, OfARangeAndABearingByHand) {
  const RangeBearingBall<Point2, Point2> ball{3, 1, {1, 0}, 3};
  EXPECT_TRUE(ball.hessian({0, 0}, {1, 0}).isZero(0));
  const Matrix<4, 4> outside = ball.hessian({0, 0}, {5, 0});  // v = (6, 0)
  EXPECT_TRUE((outside.bottomRightCorner<2, 2>().isApprox(Matrix<2, 2>(Vector<2>(1, 0.5).asDiagonal()), 1e-15))) << outside;
}

TEST(Hessian, OfAMissingDistanceAtItsSingularPointIsThatOfOmega) {
  const Matrix<5, 5> H = MissingDistanceBall<Point2, Point2>{0.5}.hessian({1, 1}, {1, 1}, Scalar(-1));
  EXPECT_EQ(H(4, 4), 4);
  EXPECT_TRUE((H.topRows<4>().isZero(0)));
}

}  // namespace
}  // namespace holdfast::testing
