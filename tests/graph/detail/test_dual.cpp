#include <gtest/gtest.h>

#include <holdfast/graph/detail/dual.hpp>

namespace holdfast {
namespace {

using D = Dual<2>;

// Each function at (x, y), over doubles and over duals; C++17 has no template lambdas with two instantiations otherwise.
struct Function {
  const char* name;
  double (*plain)(double x, double y);
  D (*dual)(const D& x, const D& y);
};

#define HOLDFAST_BOTH(expression)                                                                     \
  Function {                                                                                          \
#expression, [](double x, double y) -> double { using namespace std; (void)y; return expression; }, \
             [](const D& x, const D& y) -> D { (void)y; return expression; } \
  }

const Function kFunctions[] = {
    HOLDFAST_BOTH(x + y),       HOLDFAST_BOTH(x - y),
    HOLDFAST_BOTH(x* y),        HOLDFAST_BOTH(x / y),
    HOLDFAST_BOTH(-x),          HOLDFAST_BOTH(+x),
    HOLDFAST_BOTH(3.0 * x),     HOLDFAST_BOTH(x + 2.0),
    HOLDFAST_BOTH(1.0 / x),     HOLDFAST_BOTH(sqrt(x)),
    HOLDFAST_BOTH(sin(x)),      HOLDFAST_BOTH(cos(x)),
    HOLDFAST_BOTH(tan(x)),      HOLDFAST_BOTH(asin(x)),
    HOLDFAST_BOTH(acos(x)),     HOLDFAST_BOTH(atan(x)),
    HOLDFAST_BOTH(exp(x)),      HOLDFAST_BOTH(log(x)),
    HOLDFAST_BOTH(abs(-x)),     HOLDFAST_BOTH(pow(x, 2.5)),
    HOLDFAST_BOTH(atan2(y, x)), HOLDFAST_BOTH(hypot(x, y)),
    HOLDFAST_BOTH(max(x, y)),   HOLDFAST_BOTH(min(x, y)),
    HOLDFAST_BOTH(max(y, x)),   HOLDFAST_BOTH(exp(sin(x* y)) / sqrt(x + y * y)),
};
#undef HOLDFAST_BOTH

TEST(Dual, DerivativesAreThoseOfTheFunction) {
  constexpr double h = 1e-6;
  for (const Function& f : kFunctions)
    for (const double x : {0.2, 0.7})
      for (const double y : {-1.3, 0.4}) {
        const D result = f.dual(D(x, Vector<2>(1, 0)), D(y, Vector<2>(0, 1)));
        if (std::isnan(f.plain(x, y))) continue;
        EXPECT_DOUBLE_EQ(result.a, f.plain(x, y)) << f.name;
        EXPECT_NEAR(result.v[0], (f.plain(x + h, y) - f.plain(x - h, y)) / (2 * h), 1e-7) << f.name << " d/dx at " << x << " " << y;
        EXPECT_NEAR(result.v[1], (f.plain(x, y + h) - f.plain(x, y - h)) / (2 * h), 1e-7) << f.name << " d/dy at " << x << " " << y;
      }
}

TEST(Dual, CompoundAssignmentIsTheOperator) {
  const D x(0.7, Vector<2>(1, 0)), y(0.4, Vector<2>(0, 1));
  const auto expect_same = [](const D& a, const D& b) {
    EXPECT_EQ(a.a, b.a);
    EXPECT_EQ(a.v, b.v);
  };
  D z = x;
  expect_same(z += y, x + y);
  z = x;
  expect_same(z -= y, x - y);
  z = x;
  expect_same(z *= y, x * y);
  z = x;
  expect_same(z /= y, x / y);
  z = x;
  expect_same(z *= z, x * x);  // an operand that changes under way
}

TEST(Dual, ComparesValues) {
  const D one(1, Vector<2>(5, 5)), two(2, Vector<2>(0, 0));
  EXPECT_TRUE(one < two && two > one && one <= two && two >= one && one != two);
  EXPECT_TRUE(one == D(1.0));
  EXPECT_FALSE(one < one);
}

TEST(Dual, ConstantsHaveNoDerivative) {
  EXPECT_EQ(D(3.0).v, Vector<2>(0, 0));
  EXPECT_EQ((D(3.0) * D(4.0)).a, 12);
}

TEST(Dual, IsFiniteLooksAtTheDerivatives) {
  EXPECT_TRUE(isfinite(D(1, Vector<2>(1, 2))));
  EXPECT_FALSE(isfinite(D(1, Vector<2>(1, NAN))));
  EXPECT_FALSE(isfinite(D(INFINITY)));
}

}  // namespace
}  // namespace holdfast
