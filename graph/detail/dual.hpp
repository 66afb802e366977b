// Dual numbers: a value and its derivatives in N directions, for AutoDiff. Comparisons look at the value.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <holdfast/graph/math.hpp>

namespace holdfast {

template <int N>
struct Dual {
  double a = 0;                     ///< value
  Vector<N> v = Vector<N>::Zero();  ///< derivatives

  Dual() = default;
  Dual(double value) : a(value) {}
  Dual(double value, const Vector<N>& derivatives) : a(value), v(derivatives) {}

  Dual& operator+=(const Dual& b) { return *this = *this + b; }
  Dual& operator-=(const Dual& b) { return *this = *this - b; }
  Dual& operator*=(const Dual& b) { return *this = *this * b; }
  Dual& operator/=(const Dual& b) { return *this = *this / b; }

  friend Dual operator+(const Dual& x) { return x; }
  friend Dual operator-(const Dual& x) { return {-x.a, -x.v}; }
  friend Dual operator+(const Dual& x, const Dual& y) { return {x.a + y.a, x.v + y.v}; }
  friend Dual operator-(const Dual& x, const Dual& y) { return {x.a - y.a, x.v - y.v}; }
  friend Dual operator*(const Dual& x, const Dual& y) { return {x.a * y.a, x.a * y.v + y.a * x.v}; }
  friend Dual operator/(const Dual& x, const Dual& y) { return {x.a / y.a, (x.v - (x.a / y.a) * y.v) / y.a}; }
  friend bool operator<(const Dual& x, const Dual& y) { return x.a < y.a; }
  friend bool operator>(const Dual& x, const Dual& y) { return x.a > y.a; }
  friend bool operator<=(const Dual& x, const Dual& y) { return x.a <= y.a; }
  friend bool operator>=(const Dual& x, const Dual& y) { return x.a >= y.a; }
  friend bool operator==(const Dual& x, const Dual& y) { return x.a == y.a; }
  friend bool operator!=(const Dual& x, const Dual& y) { return x.a != y.a; }

  friend Dual sqrt(const Dual& x) {
    const double root = std::sqrt(x.a);
    return {root, x.v * (0.5 / root)};
  }
  friend Dual sin(const Dual& x) { return {std::sin(x.a), std::cos(x.a) * x.v}; }
  friend Dual cos(const Dual& x) { return {std::cos(x.a), -std::sin(x.a) * x.v}; }
  friend Dual tan(const Dual& x) { return {std::tan(x.a), x.v / (std::cos(x.a) * std::cos(x.a))}; }
  friend Dual asin(const Dual& x) { return {std::asin(x.a), x.v / std::sqrt(1 - x.a * x.a)}; }
  friend Dual acos(const Dual& x) { return {std::acos(x.a), -x.v / std::sqrt(1 - x.a * x.a)}; }
  friend Dual atan(const Dual& x) { return {std::atan(x.a), x.v / (1 + x.a * x.a)}; }
  friend Dual exp(const Dual& x) { return {std::exp(x.a), std::exp(x.a) * x.v}; }
  friend Dual log(const Dual& x) { return {std::log(x.a), x.v / x.a}; }
  friend Dual abs(const Dual& x) { return x.a < 0 ? -x : x; }
  friend Dual pow(const Dual& x, double k) { return {std::pow(x.a, k), k * std::pow(x.a, k - 1) * x.v}; }
  friend Dual atan2(const Dual& y, const Dual& x) { return {std::atan2(y.a, x.a), (x.a * y.v - y.a * x.v) / (x.a * x.a + y.a * y.a)}; }
  friend Dual hypot(const Dual& x, const Dual& y) { return sqrt(x * x + y * y); }
  friend Dual max(const Dual& x, const Dual& y) { return x.a < y.a ? y : x; }
  friend Dual min(const Dual& x, const Dual& y) { return y.a < x.a ? y : x; }
  friend bool isfinite(const Dual& x) { return std::isfinite(x.a) && x.v.array().isFinite().all(); }
};

}  // namespace holdfast

template <int N>
struct Eigen::NumTraits<holdfast::Dual<N>> : Eigen::NumTraits<double> {
  using Real = holdfast::Dual<N>;
  using NonInteger = holdfast::Dual<N>;
  using Nested = holdfast::Dual<N>;
  using Literal = double;
  enum { IsComplex = 0, IsInteger = 0, IsSigned = 1, RequireInitialization = 1, ReadCost = 1 + N, AddCost = 1 + N, MulCost = 3 * N };
};
