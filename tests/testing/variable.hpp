// check_variable: does a variable type keep the contract of graph/manifold.hpp? For tests of yours (installed):
//
//   EXPECT_EQ(holdfast::testing::check_variable<MyState>(), "");
//
// The answer is what is wrong, in words; empty where nothing is. Checked at the identity, near it (1e-8) and at random: retract and local
// undo each other; nothing moves by zero; a vector space adds; the position moves by position_jacobian(); local_jacobian(), where it has
// one, is a derivative; is_finite() sees a NaN; the struct is doubles and nothing else.
#pragma once

#include <holdfast/testing.hpp>
#include <sstream>
#include <string>

namespace holdfast::testing {

namespace detail {

template <class V, class = void>
struct HasLocalJacobian : std::false_type {};
template <class V>
struct HasLocalJacobian<V, std::void_t<decltype(std::declval<const V&>().local_jacobian(std::declval<const V&>()))>> : std::true_type {};

template <class V>
class VariableChecker {
 public:
  using Tangent = Vector<V::dim>;

  std::string broken() {
    if (std::string(V::name()).empty()) text_ << "name() is empty\n";
    if (!std::is_standard_layout_v<V> || sizeof(V) % sizeof(double) != 0) text_ << "it is not a plain struct of doubles\n";
    std::mt19937_64 rng(11);
    std::vector<V> states{V{}};
    for (int i = 0; i < 5; ++i) states.push_back(near_identity<V>(rng));
    for (int i = 0; i < 10; ++i) states.push_back(random_variable<V>(rng));
    for (const V& x : states) {
      check_moves(x, rng);
      check_position(x, rng);
      for (const V& y : states) check_pair(x, y);
      if (!text_.str().empty()) break;
    }
    return text_.str();
  }

 private:
  void expect(bool right, const char* what, double off) {
    if (!right) text_ << what << " (off by " << off << ")\n";
  }
  void check_moves(const V& x, std::mt19937_64& rng) {
    const double scale = 1 + x.local(V{}).norm();
    expect_small(x.local(x), 1e-14 * scale, "x.local(x) is not 0");
    expect_small(x.local(x.retract(Tangent::Zero())), 1e-14 * scale, "x.retract(0) is not x");
    for (const double size : {1e-8, 1e-4, 0.3, 1.5}) {
      const Tangent delta = size * random_unit<V::dim>(rng);
      expect_small(x.local(x.retract(delta)) - delta, 1e-12 * scale, "x.local(x.retract(delta)) is not delta");
      const Tangent more = random_unit<V::dim>(rng);
      if (is_vector_space<V>)
        expect_small(x.retract(delta).retract(more).local(x.retract(Tangent(delta + more))), 1e-12 * scale,
                     "is_vector_space, but x.retract(a).retract(b) is not x.retract(a + b)");
    }
    if (!x.is_finite()) text_ << "is_finite() says no of a finite variable\n";
    if (x.retract(Tangent::Constant(std::numeric_limits<double>::quiet_NaN())).is_finite()) text_ << "is_finite() does not see a NaN\n";
  }
  void check_pair(const V& x, const V& y) {
    expect_small(y.local(x.retract(x.local(y))), 1e-11 * (1 + x.local(y).norm()), "x.retract(x.local(y)) is not y");
    if constexpr (HasLocalJacobian<V>::value) {
      const Matrix<V::dim, V::dim> J = x.local_jacobian(y);
      Matrix<V::dim, V::dim> numeric;
      const auto slope = [&](int c, double h) -> Tangent {
        return (x.local(y.retract(Tangent(h * Tangent::Unit(c)))) - x.local(y.retract(Tangent(-h * Tangent::Unit(c))))) / (2 * h);
      };
      for (int c = 0; c < V::dim; ++c) numeric.col(c) = (4 * slope(c, 5e-4) - slope(c, 1e-3)) / 3;
      const double error = (J - numeric).cwiseAbs().maxCoeff();
      const bool near_the_cut = !(numeric.cwiseAbs().maxCoeff() < 100);  // local() jumps where a rotation is half a turn away
      expect(near_the_cut || error < 1e-6, "local_jacobian() is not the derivative of local()", error);
    }
  }
  void check_position(const V& x, std::mt19937_64& rng) {
    if constexpr (space_dim<V> != 0) {
      const Tangent delta = random_vector<V::dim>(rng, 0.5);
      const Vector<V::space_dim> off = x.retract(delta).position() - x.position() - V::position_jacobian() * delta;
      expect(off.norm() < 1e-12 * (1 + x.position().norm()), "the position does not move by position_jacobian() * delta", off.norm());
    }
  }
  void expect_small(const Tangent& off, double tolerance, const char* what) { expect(off.norm() <= tolerance, what, off.norm()); }

  std::ostringstream text_;
};

}  // namespace detail

template <class V>
std::string check_variable() {
  return detail::VariableChecker<V>().broken();
}

}  // namespace holdfast::testing
