// The samples themselves, and the tools of testing.hpp.
#include <gtest/gtest.h>

#include <set>

#include "tests/samples.hpp"

namespace holdfast::testing {
namespace {

template <class F>
void expect_nan_is_seen() {
  SCOPED_TRACE(factor_name<F>());
  std::mt19937_64 rng(3);
  const F factor = Sample<F>::factor(rng);
  auto x = Sample<F>::variables(rng);
  using First = typename F::Variables::template type<0>;
  std::get<0>(x) = std::get<0>(x).retract(Vector<First::dim>::Constant(std::nan("")));
  EXPECT_FALSE(std::isfinite(std::apply([&](const auto&... v) { return factor(v...).squaredNorm(); }, x)));
}

TEST(Samples, ANonFiniteVariableReachesTheResidual) {
  for_each_type<SomeFactors>([](auto tag) { expect_nan_is_seen<typename decltype(tag)::type>(); });
}

TEST(Samples, EveryOneSidedFactorIsDrawnOnBothSides) {
  using F = RangeBall<Point2, Point2>;
  std::mt19937_64 rng(1);
  std::set<bool> active;
  for (int i = 0; i < 20; ++i) {
    const F factor = Sample<F>::factor(rng);
    const auto [a, b] = Sample<F>::variables(rng);
    active.insert(factor(a, b).norm() > 0);
  }
  EXPECT_EQ(active.size(), 2u);
}

/// sin x, with a Jacobian that can be spoilt.
struct Sine {
  double slope_error;
  bool forgets;
  using Variables = variables<Scalar>;
  static constexpr int residual_dim = 1;
  Vector<1> operator()(const Scalar& x, Jacobians<Sine>* J = nullptr) const {
    if (J != nullptr && !forgets) J->all(0, 0) = std::cos(x.value) + slope_error;
    return Vector<1>(std::sin(x.value));
  }
};

TEST(JacobianError, FindsWrongAndMissingEntries) {
  EXPECT_LT(jacobian_error(Sine{0, false}, Scalar(0.7)), 1e-11);
  EXPECT_NEAR(jacobian_error(Sine{1e-5, false}, Scalar(0.7)), 1e-5 / (1 + std::cos(0.7)), 1e-9);
  EXPECT_EQ(jacobian_error(Sine{0, true}, Scalar(0.7)), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace holdfast::testing
