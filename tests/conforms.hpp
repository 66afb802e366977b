// HOLDFAST_CONFORMS: the line in a factor's test (tests/factors/test_range.cpp) that enters it into the conformance tests. They run it with
// random instances and variables through every loss, back-end and foreign library (tests/…/test_*every_factor.cpp).
//
//   #include "tests/conforms.hpp"
//   HOLDFAST_CONFORMS(OnPairs<Range>, Range<Accel2, Point2>);      // outside all namespaces; lists of types, and types
//
// A random instance is made from the factor's fields(): a double between 0.5 and 2, an int between 1 and 4, a unit vector, the root of
// a random information matrix, a variable near the origin. A factor whose fields mean more than that has a generator in its test:
//
//   template <class A, class B>
//   struct holdfast::testing::Sample<RangeBall<A, B>> : RandomVariables<RangeBall<A, B>> {
//     static RangeBall<A, B> factor(std::mt19937_64& rng) { return {radius(rng), uniform(rng, 0.5, 2)}; }
//   };
//
// Any instance fits any variables: positions are 6 to 20 m apart, while the radius of a one-sided factor is 1 to 3 m (active) or 45 to 60 m
// (inactive), and rotation errors stay below 2.6 rad. So no factor is near a point where it has a kink.
#pragma once

#include <Eigen/Cholesky>
#include <holdfast/factors/detail/body_frame.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/graph/variables.hpp>
#include <holdfast/testing.hpp>

#include "tests/draws.hpp"

namespace holdfast::testing {

// ---- lists of types

template <class... Lists>
using Concat = decltype(std::tuple_cat(std::declval<Lists>()...));

/// F on pairs of variables with a position: the same type twice, and mixed.
template <template <class, class> class F>
using OnPairs = std::tuple<F<Point2, Point2>, F<Motion2, Motion2>, F<Pose2, Pose2>, F<Pose2, Point2>, F<Point3, Point3>, F<Accel3, Motion3>,
                           F<Pose3, Pose3>, F<Pose3, Point3>>;
/// Two of them, where F is made of what was run on every pair: how a displacement reaches the tangents (factors/detail/displacement.hpp).
template <template <class, class> class F>
using OnSomePairs = std::tuple<F<Pose2, Point2>, F<Accel3, Motion3>>;
/// F on a pose and whatever has a position.
template <template <class, class> class F>
using OnPoses = std::tuple<F<Pose2, Point2>, F<Pose2, Accel2>, F<Pose2, Pose2>, F<Pose3, Point3>, F<Pose3, Motion3>, F<Pose3, Pose3>>;
/// F on every variable type.
template <template <class> class F>
using OnAll = std::tuple<F<Scalar>, F<Point2>, F<Motion2>, F<Accel2>, F<Pose2>, F<Point3>, F<Motion3>, F<Accel3>, F<Pose3>>;

namespace detail {
template <class T>
struct AsList {
  using type = std::tuple<T>;
};
template <class... T>
struct AsList<std::tuple<T...>> {
  using type = std::tuple<T...>;
};
}  // namespace detail

/// Lists of types and types, as one list.
template <class... T>
using Flat = Concat<typename detail::AsList<T>::type...>;

// ---- random variables of a factor

/// The radius that a one-sided factor switches at: well below or well above the distances of the samples.
inline double radius(std::mt19937_64& rng) { return uniform(rng, 0, 1) < 0.7 ? uniform(rng, 1, 3) : uniform(rng, 45, 60); }

/// A little turned from `from`, at most `angle` [rad]; position and the rest anywhere.
template <class V>
V near_rotation(const V& from, double angle, std::mt19937_64& rng) {
  Vector<V::dim> delta = random_vector<V::dim>(rng, 3);
  if constexpr (is_pose<V>) {
    constexpr int turn = rotation_dim<V::space_dim>;
    delta.template tail<turn>() = random_unit<turn>(rng) * uniform(rng, 0, angle);
  }
  return from.retract(delta);
}

template <class V>
V moved_to(const V& x, const Vector<V::space_dim>& p) {
  return x.retract(V::position_jacobian().transpose() * (p - x.position()));
}

namespace detail {

template <class V>
std::tuple<V> random_variables(variables<V>*, std::mt19937_64& rng) {
  return {near_rotation(V{}, 1.5, rng)};
}

template <class A, class B, class... Rest>
std::tuple<A, B, Rest...> random_variables(variables<A, B, Rest...>*, std::mt19937_64& rng) {
  const A a = random_variable<A>(rng);
  B b = random_variable<B>(rng);
  if constexpr (std::is_same_v<A, B>) b = near_rotation(a, 1.5, rng);
  if constexpr (space_dim<A> != 0 && space_dim<A> == space_dim<B>) {
    const Vector<space_dim<A>> offset = uniform(rng, 6, 20) * random_unit<space_dim<A>>(rng);
    b = moved_to(b, a.position() + offset);
  }
  return {a, b, near_rotation(Rest{}, 1.5, rng)...};
}

}  // namespace detail

template <class F>
struct RandomVariables {
  static typename F::Variables::Tuple variables(std::mt19937_64& rng) {
    return detail::random_variables(static_cast<typename F::Variables*>(nullptr), rng);
  }
};

// ---- random factors

namespace detail {

inline Eigen::MatrixXd random_information(int n, std::mt19937_64& rng) {
  Eigen::MatrixXd I = random_covariance(n, rng, 0.1);
  Eigen::VectorXd silent(n);
  std::normal_distribution<double> normal;
  for (int i = 0; i < n; ++i) silent[i] = normal(rng);
  silent.normalize();
  const Eigen::MatrixXd others = Eigen::MatrixXd::Identity(n, n) - silent * silent.transpose();
  const double kind = uniform(rng, 0, 1);
  if (kind < 0.25) I.row(0).setZero(), I.col(0).setZero();
  if (kind > 0.75) I = others * I * others;
  return 0.5 * (I + I.transpose());
}

}  // namespace detail

/// An information matrix. One of four says nothing of its first component, one of four nothing of a direction between all of them.
template <int N>
Matrix<N, N> random_information(std::mt19937_64& rng) {
  return detail::random_information(N, rng);
}

namespace detail {

/// visit(field) for every field that the struct lists, in order.
template <class F, class Visit>
void for_each_field(F& f, const Visit& visit) {
  std::apply([&](const auto&... field) { (visit(f.*field.member), ...); }, F::fields());
}

/// A plausible value of a field, by its type alone.
template <class T>
void draw_field(T& field, std::mt19937_64& rng) {
  if constexpr (std::is_same_v<T, double>) {
    field = uniform(rng, 0.5, 2);
  } else if constexpr (std::is_same_v<T, int>) {
    field = static_cast<int>(uniform(rng, 1, 5));
  } else if constexpr (holdfast::detail::IsFixedMatrix<T>::value) {
    constexpr int rows = T::RowsAtCompileTime, cols = T::ColsAtCompileTime;
    if constexpr (cols == 1)
      field = random_unit<rows>(rng);
    else if constexpr (rows == cols)
      field = Eigen::LLT<Eigen::MatrixXd>(random_covariance(rows, rng, 0.1)).matrixU();
    else
      for (int c = 0; c < cols; ++c) field.col(c) = random_vector<rows>(rng);
  } else if constexpr (!std::is_enum_v<T>) {  // an enum stays as it is
    field = near_rotation(T{}, 1, rng);
  }
}

}  // namespace detail

template <class F>
struct Sample : RandomVariables<F> {
  static F factor(std::mt19937_64& rng) {
    F factor{};
    detail::for_each_field(factor, [&](auto& field) { detail::draw_field(field, rng); });
    return factor;
  }
};

// ---- a factor without its types

namespace detail {

/// Every floating-point number in the struct: doubles, entries of matrices, the numbers of variables.
template <class F>
std::vector<double*> numbers_of(F& f) {
  std::vector<double*> numbers;
  for_each_field(f, [&](auto& field) {
    using T = std::decay_t<decltype(field)>;
    if constexpr (holdfast::detail::HasFields<T>::value) {
      for (double* number : numbers_of(field)) numbers.push_back(number);
    } else if constexpr (!std::is_integral_v<T> && !std::is_enum_v<T>) {
      static_assert(sizeof(T) % sizeof(double) == 0, "a field that is not made of doubles");
      double* first = reinterpret_cast<double*>(&field);
      for (std::size_t i = 0; i < sizeof(T) / sizeof(double); ++i) numbers.push_back(first + i);
    }
  });
  return numbers;
}

template <class F, class Keys, std::size_t... I>
void set_variables(Draw& draw, const Keys& keys, std::index_sequence<I...>) {
  using Vars = typename F::Variables;
  draw.label = factor_name<F>() + " on" + ((std::string(" ") + Vars::template type<I>::name()) + ...);
  draw.keys.assign(keys.begin(), keys.end());
  draw.values = [keys](std::mt19937_64& random) {
    const auto x = Sample<F>::variables(random);
    Values values;
    (values.insert(keys[I], std::get<I>(x)), ...);
    return values;
  };
  draw.add_priors = [keys](Graph& graph, const Values& near, std::mt19937_64& random) {
    const auto add = [&](const auto& x, Key key) {
      using V = std::decay_t<decltype(x)>;
      graph.add(Prior<V>::from_sigmas(x.retract(random_vector<V::dim>(random, 0.1)), Vector<V::dim>::Constant(0.1)), {key});
    };
    (add(near.at<typename Vars::template type<I>>(keys[I]), keys[I]), ...);
  };
}

template <class F, class Keys, std::size_t... I>
void set_residual(Draw& draw, const F& factor, const Keys& keys, std::index_sequence<I...>) {
  draw.residual = [factor, keys](const Values& values, Eigen::MatrixXd* jacobian) -> Eigen::VectorXd {
    const auto residual = [&](Jacobians<F>* J) { return factor(values.at<typename F::Variables::template type<I>>(keys[I])..., J); };
    if (jacobian == nullptr) return residual(nullptr);
    Jacobians<F> J;
    J.all.setConstant(std::numeric_limits<double>::quiet_NaN());
    const Eigen::VectorXd r = residual(&J);
    *jacobian = J.all;
    return r;
  };
}

template <class F, class Keys, std::size_t... I>
void set_hessian(Draw& draw, const F& factor, const Keys& keys, std::index_sequence<I...>) {
  draw.hessian = [factor, keys](const Values& values) -> Eigen::MatrixXd {
    return factor.hessian(values.at<typename F::Variables::template type<I>>(keys[I])...);
  };
}

template <class F, class Keys>
void set_numbers(Draw& draw, const F& factor, const Keys& keys) {
  F copy = factor;
  draw.numbers = static_cast<int>(numbers_of(copy).size());
  draw.add_spoilt = [factor, keys](Graph& graph, int number, double bad) {
    F spoilt = factor;
    *numbers_of(spoilt)[number] = bad;
    graph.add(spoilt, keys);
  };
}

template <class F, std::size_t... I>
Draw draw_of(std::mt19937_64& rng, std::index_sequence<I...> indices) {
  static_assert(std::is_aggregate_v<F>, "a factor is a plain struct");
  const F factor = Sample<F>::factor(rng);
  const std::array<Key, sizeof...(I)> keys{Key(static_cast<char>('C' - I), 7 + 3 * I)...};
  Draw draw;
  draw.residual_dim = F::residual_dim;
  draw.linear = is_linear<F>;
  draw.convex = is_convex<F>;
  draw.validates = holdfast::detail::HasValidate<F>::value;
  set_variables<F>(draw, keys, indices);
  set_residual<F>(draw, factor, keys, indices);
  if constexpr (holdfast::detail::HasHessian<F>::value) set_hessian(draw, factor, keys, indices);
  if constexpr (holdfast::detail::HasValidate<F>::value) set_numbers(draw, factor, keys);
  draw.add = [factor, keys](Graph& graph, const Loss& loss, double weight) { graph.add(factor, keys, loss, weight); };
  draw.layouts = holdfast::detail::layouts_of<F>();
  draw.term = [factor](const Loss& loss, double weight) { return Term(factor, loss, weight); };
  return draw;
}

template <class... F>
std::vector<Draw> draws_of(std::tuple<F...>*, std::mt19937_64& rng) {
  return {draw_of<F>(rng, std::make_index_sequence<F::Variables::size>{})...};
}

}  // namespace detail

template <class List>
bool enter(const char* text) {
  return conforming_factors().emplace(text, [](std::mt19937_64& rng) { return detail::draws_of(static_cast<List*>(nullptr), rng); }).second;
}

}  // namespace holdfast::testing

#define HOLDFAST_CONFORMS(...)                                                                               \
  namespace holdfast::testing {                                                                              \
  [[maybe_unused]] static const bool conforms = ::holdfast::testing::enter<Flat<__VA_ARGS__>>(#__VA_ARGS__); \
  }                                                                                                          \
  static_assert(true, "")
