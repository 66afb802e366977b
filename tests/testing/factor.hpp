// check_factor: does a factor keep the contract of graph/factor.hpp? For tests of yours (installed):
//
//   EXPECT_EQ(holdfast::testing::check_factor(MyRange{12.3, 0.5}), "");                      // at 20 random states
//   EXPECT_EQ(holdfast::testing::check_factor_at(MyRange{12.3, 0.5}, robot, beacon), "");    // at these variables
//
// The answer is what is wrong, in words; empty where nothing is. Checked: the residual is finite and the same with and without a Jacobian;
// every entry of the Jacobian is written, and is the derivative of the residual; the factor is linear, or convex, where it says so; its
// hessian(), where it has one, is the second derivative of ½‖r‖², symmetric, and positive semidefinite where the factor is convex;
// validate() lets it pass.
#pragma once

#include <Eigen/Eigenvalues>
#include <holdfast/testing.hpp>
#include <sstream>
#include <string>

namespace holdfast::testing {

namespace detail {

/// One factor at one state.
template <class F>
class FactorChecker {
 public:
  using Vars = typename F::Variables;
  static constexpr int dim = Vars::total_dim;
  using Delta = Vector<dim>;

  FactorChecker(const F& factor, const typename Vars::Tuple& x) : factor_(factor), x_(x) {}

  std::string broken() {
    check_residual();
    if (text_.str().empty()) check_jacobian();
    if (text_.str().empty()) check_claims();
    if constexpr (holdfast::detail::HasHessian<F>::value) check_hessian();
    return text_.str();
  }

 private:
  template <std::size_t... I>
  Residual<F> residual_at(const Delta& delta, std::index_sequence<I...>) const {
    return factor_(std::get<I>(x_).retract(Vector<Vars::dims[I]>(delta.template segment<Vars::dims[I]>(Vars::offsets[I])))...);
  }
  Residual<F> residual_at(const Delta& delta) const { return residual_at(delta, std::make_index_sequence<Vars::size>{}); }
  double cost_at(const Delta& delta) const { return 0.5 * residual_at(delta).squaredNorm(); }

  void check_residual() {
    J_.all.setConstant(std::numeric_limits<double>::quiet_NaN());
    r_ = std::apply([&](const auto&... v) { return factor_(v..., &J_); }, x_);
    const Residual<F> without = std::apply([&](const auto&... v) { return factor_(v...); }, x_);
    if (!r_.allFinite()) text_ << "the residual is not finite: " << r_.transpose() << "\n";
    if (!(r_ == without))
      text_ << "the residual is " << r_.transpose() << " with a Jacobian and " << without.transpose() << " without one\n";
  }
  /// "d r[0] / d variable 1, component 2"
  void name_entry(int row, int column) {
    int variable = 0;
    while (variable + 1 < Vars::size && Vars::offsets[variable + 1] <= column) ++variable;
    text_ << "d r[" << row << "] / d variable " << variable << ", component " << column - Vars::offsets[variable];
  }
  void check_jacobian() {
    const auto numeric = std::apply([&](const auto&... v) { return numeric_jacobian(factor_, v...); }, x_);
    const double tolerance = 1e-7 * (1 + numeric.all.cwiseAbs().maxCoeff());
    for (int row = 0; row < F::residual_dim; ++row)
      for (int column = 0; column < dim && text_.str().empty(); ++column) {
        const double is = J_.all(row, column), should = numeric.all(row, column);
        if (std::abs(is - should) <= tolerance) continue;
        name_entry(row, column);
        if (std::isnan(is))
          text_ << " is not written\n";
        else
          text_ << " is " << is << ", but differences of the residual say " << should << "\n";
      }
  }
  void check_claims() {
    std::mt19937_64 rng(5);
    for (int i = 0; i < 5; ++i) {
      const Delta delta = random_vector<dim>(rng, 2);
      const Residual<F> there = residual_at(delta), predicted = r_ + J_.all * delta;
      const double scale = 1 + r_.norm() + there.norm();
      if (is_linear<F> && (there - predicted).norm() > 1e-9 * scale)
        text_ << "is_linear, but moved by " << delta.transpose() << " it is off its linear model by " << (there - predicted).norm() << "\n";
      const double rise = 0.5 * there.squaredNorm() - 0.5 * r_.squaredNorm() - r_.dot(J_.all * delta);
      if (is_convex<F> && rise < -1e-9 * scale * scale)
        text_ << "is_convex, but moved by " << delta.transpose() << " ½‖r‖² lies " << -rise << " below its tangent\n";
      if (!text_.str().empty()) return;
    }
  }
  double second_difference(int i, int j, double h) const {
    const Delta a = h * Delta::Unit(i), b = h * Delta::Unit(j);
    return (cost_at(a + b) - cost_at(a - b) - cost_at(b - a) + cost_at(-a - b)) / (4 * h * h);
  }
  void check_hessian() {
    const Matrix<dim, dim> H = std::apply([&](const auto&... v) { return factor_.hessian(v...); }, x_);
    const double scale = 1 + H.cwiseAbs().maxCoeff() + r_.squaredNorm();
    if (!((H - H.transpose()).cwiseAbs().maxCoeff() <= 1e-9 * scale)) text_ << "hessian() is not symmetric\n" << H << "\n";
    for (int i = 0; i < dim; ++i)
      for (int j = 0; j <= i && text_.str().empty(); ++j) {
        const double should = (4 * second_difference(i, j, 1e-3) - second_difference(i, j, 2e-3)) / 3;
        if (!(std::abs(H(i, j) - should) <= 1e-5 * scale))
          text_ << "hessian()(" << i << ", " << j << ") is " << H(i, j) << ", but second differences of ½‖r‖² say " << should << "\n";
      }
    const double least = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(H).eigenvalues()[0];
    if (is_convex<F> && !(least >= -1e-9 * scale)) text_ << "is_convex, but hessian() has the eigenvalue " << least << "\n";
  }

  const F& factor_;
  typename Vars::Tuple x_;
  Residual<F> r_;
  Jacobians<F> J_;
  std::ostringstream text_;
};

template <class F>
std::string refused_by_validate(const F& factor) {
  if constexpr (holdfast::detail::HasValidate<F>::value) {
    try {
      factor.validate();
    } catch (const std::exception& error) {
      return std::string("validate() refuses it: ") + error.what() + "\n";
    }
  }
  return "";
}

template <class... V>
std::tuple<V...> random_state(std::tuple<V...>*, std::mt19937_64& rng) {
  return {random_variable<V>(rng)...};
}

}  // namespace detail

/// At these variables, which should not lie where the factor has a kink.
template <class F, class... V>
std::string check_factor_at(const F& factor, const V&... x) {
  return detail::refused_by_validate(factor) + detail::FactorChecker<F>(factor, {x...}).broken();
}

/// At 20 random states: some metres from the origin, turned anyhow.
template <class F>
std::string check_factor(const F& factor) {
  using Tuple = typename F::Variables::Tuple;
  std::mt19937_64 rng(1);
  std::string broken = detail::refused_by_validate(factor);
  for (int i = 0; i < 20 && broken.empty(); ++i)
    broken = detail::FactorChecker<F>(factor, detail::random_state(static_cast<Tuple*>(nullptr), rng)).broken();
  return broken.empty() ? broken : factor_name<F>() + ": " + broken;
}

}  // namespace holdfast::testing
