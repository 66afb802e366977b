// For tests of what you write yourself (installed; needs Eigen only). Each check is one line and returns what is wrong, in words:
//
//   #include <holdfast/testing/factor.hpp>      EXPECT_EQ(holdfast::testing::check_factor(MyRange{12.3, 0.5}), "");
//   #include <holdfast/testing/loss.hpp>        EXPECT_EQ(holdfast::testing::check_loss(MyLoss{2.0}), "");
//   #include <holdfast/testing/variable.hpp>    EXPECT_EQ(holdfast::testing::check_variable<MyState>(), "");
//   #include <holdfast/testing/backend.hpp>     EXPECT_EQ(holdfast::testing::check_backend(MyBackend()), "");
//
// This header: random variables and numeric Jacobians, what the checks are made of.
#pragma once

#include <holdfast/graph/factor.hpp>
#include <limits>
#include <random>

namespace holdfast::testing {

/// Independent normal components.
template <int N>
Vector<N> random_vector(std::mt19937_64& rng, double sigma = 1) {
  std::normal_distribution<double> normal;  // which must not be given a sigma of 0
  Vector<N> v;
  for (int i = 0; i < N; ++i) v[i] = sigma * normal(rng);
  return v;
}

inline double uniform(std::mt19937_64& rng, double low, double high) { return std::uniform_real_distribution<double>(low, high)(rng); }

template <int N>
Vector<N> random_unit(std::mt19937_64& rng) {
  return random_vector<N>(rng).normalized();
}

namespace detail {

// Of run-time size: Eigen's products of fixed size cost the compiler a second each.
inline Eigen::MatrixXd random_covariance(int n, std::mt19937_64& rng, double floor) {
  Eigen::MatrixXd A(n, n);
  for (int column = 0; column < n; ++column) {
    std::normal_distribution<double> normal;
    for (int row = 0; row < n; ++row) A(row, column) = 0.5 * normal(rng);
  }
  return A * A.transpose() + floor * Eigen::MatrixXd::Identity(n, n);
}

}  // namespace detail

/// Symmetric, eigenvalues at least `floor`.
template <int N>
Matrix<N, N> random_covariance(std::mt19937_64& rng, double floor = 0.1) {
  return detail::random_covariance(N, rng, floor);
}

/// Some metres from the origin, turned anyhow.
template <class V>
V random_variable(std::mt19937_64& rng) {
  return V{}.retract(random_vector<V::dim>(rng, 5));
}

/// Where series and limits take over.
template <class V>
V near_identity(std::mt19937_64& rng, double size = 1e-8) {
  return V{}.retract(random_vector<V::dim>(rng, size));
}

namespace detail {

template <class F, class Tuple, std::size_t... I>
Residual<F> residual_moved(const F& factor, const Tuple& x, int column, double step, std::index_sequence<I...>) {
  const auto moved = [&](const auto& variable, int first) {
    using V = std::decay_t<decltype(variable)>;
    Vector<V::dim> delta = Vector<V::dim>::Zero();
    if (column >= first && column < first + V::dim) delta[column - first] = step;
    return variable.retract(delta);
  };
  return factor(moved(std::get<I>(x), F::Variables::offsets[I])...);
}

}  // namespace detail

/// d residual / d tangent by central differences over two steps, extrapolated: the error is of fourth order in the step.
template <class F, class... V>
auto numeric_jacobian(const F& factor, const V&... x) {
  constexpr double step = 1e-3;
  const std::tuple<V...> all(x...);
  const auto slope = [&](int column, double h) -> Residual<F> {
    constexpr std::index_sequence_for<V...> indices{};
    return (detail::residual_moved(factor, all, column, h, indices) - detail::residual_moved(factor, all, column, -h, indices)) / (2 * h);
  };
  Jacobians<F> J;
  for (int column = 0; column < F::Variables::total_dim; ++column)
    J.all.col(column) = (4 * slope(column, step / 2) - slope(column, step)) / 3;
  return J;
}

/// The largest difference between the factor's Jacobian and the numeric one, relative to 1 + the largest entry. Infinite where the
/// factor leaves an entry unwritten, or where asking for the Jacobian changes the residual.
template <class F, class... V>
double jacobian_error(const F& factor, const V&... x) {
  Jacobians<F> J;
  J.all.setConstant(std::numeric_limits<double>::quiet_NaN());
  const Residual<F> with = factor(x..., &J);
  const Residual<F> without = factor(x...);
  if (!(with == without) || !J.all.array().isFinite().all()) return std::numeric_limits<double>::infinity();
  const double error = (J.all - numeric_jacobian(factor, x...).all).cwiseAbs().maxCoeff();
  return error / (1 + J.all.cwiseAbs().maxCoeff());
}

}  // namespace holdfast::testing
