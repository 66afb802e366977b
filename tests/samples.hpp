// Every factor × variable types of the library with random instances: what draws.hpp, and the conformance tests with it, are made of.
//
//   for_each_type<AllFactors>([](auto tag) {
//     using F = typename decltype(tag)::type;
//     F factor = Sample<F>::factor(rng);
//     typename F::Variables::Tuple x = Sample<F>::variables(rng);
//   });
//
// Any factor drawn fits any variables drawn: positions are 6 to 20 m apart, while the radius of a one-sided factor is 1 to 3 m (active)
// or 45 to 60 m (inactive), and rotation errors stay below 2.6 rad. So a sample is never near a point where a factor has a kink.
#pragma once

#include <holdfast/factors/bearing_ray.hpp>
#include <holdfast/factors/between.hpp>
#include <holdfast/factors/constant_turn.hpp>
#include <holdfast/factors/huber_measurement.hpp>
#include <holdfast/factors/missing_distance.hpp>
#include <holdfast/factors/position_step.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/range.hpp>
#include <holdfast/factors/range_ball.hpp>
#include <holdfast/factors/range_bearing.hpp>
#include <holdfast/factors/range_bearing_ball.hpp>
#include <holdfast/factors/relative_point.hpp>
#include <holdfast/factors/von_mises_bearing.hpp>
#include <holdfast/factors/white_acceleration.hpp>
#include <holdfast/factors/white_jerk.hpp>
#include <holdfast/testing.hpp>

namespace holdfast::testing {

// ---- lists of types

template <class... Lists>
using Concat = decltype(std::tuple_cat(std::declval<Lists>()...));

/// F on pairs of variables with a position: the same type twice, and mixed.
template <template <class, class> class F>
using OnPairs = std::tuple<F<Point2, Point2>, F<Motion2, Motion2>, F<Pose2, Pose2>, F<Pose2, Point2>, F<Point3, Point3>, F<Accel3, Motion3>,
                           F<Pose3, Pose3>, F<Pose3, Point3>>;
/// The same where every pair was run with the parts that F is made of.
template <template <class, class> class F>
using OnSomePairs = std::tuple<F<Pose2, Point2>, F<Accel3, Motion3>>;
/// F on a pose and whatever has a position.
template <template <class, class> class F>
using OnPoses = std::tuple<F<Pose2, Point2>, F<Pose2, Accel2>, F<Pose2, Pose2>, F<Pose3, Point3>, F<Pose3, Motion3>, F<Pose3, Pose3>>;
/// F on every variable type.
template <template <class> class F>
using OnAll = std::tuple<F<Scalar>, F<Point2>, F<Motion2>, F<Accel2>, F<Pose2>, F<Point3>, F<Motion3>, F<Accel3>, F<Pose3>>;

using LinearFactors =
    std::tuple<HuberMeasurement<Point2>, HuberMeasurement<Motion2>, HuberMeasurement<Accel2>, HuberMeasurement<Point3>,
               HuberMeasurement<Motion3>, HuberMeasurement<Motion2, 4>, HuberMeasurementEdge<Motion2, Motion2>,
               HuberMeasurementEdge<Point2, Motion2>, HuberMeasurementEdge<Point3, Motion3>, WhiteAcceleration<Motion2>,
               WhiteAcceleration<Motion3>, WhiteJerk<Accel2>, WhiteJerk<Accel3>, ConstantTurn<Motion2>, MissingDistancePrior>;
using RangeFactors = Concat<OnPairs<Range>, OnPairs<RangeBall>, OnPairs<RangeBearingBall>>;
using MissingFactors = Concat<OnPairs<MissingDistance>, OnPairs<MissingDistanceBall>>;
using DirectionFactors = Concat<OnPairs<VonMisesBearing>, OnPoses<VonMisesBearingBody>, OnPoses<RelativePoint>, OnPairs<PositionStep>,
                                OnSomePairs<RangeBearing>, OnSomePairs<BearingRay>>;
using StateFactors = Concat<OnAll<Prior>, OnAll<Between>>;
// Each of these lists has its draws (draws/).
using AllFactors = Concat<LinearFactors, RangeFactors, MissingFactors, DirectionFactors, StateFactors>;

/// Each factor once, for tests that cost much a type.
using SomeFactors = std::tuple<Prior<Pose3>, Between<Pose2>, Between<Pose3>, Between<Point2>, RelativePoint<Pose2, Point2>,
                               Range<Pose2, Point2>, RangeBall<Point3, Point3>, VonMisesBearing<Point2, Motion2>,
                               VonMisesBearingBody<Pose3, Point3>, RangeBearingBall<Point2, Point2>, HuberMeasurement<Motion2>,
                               HuberMeasurementEdge<Point2, Motion2>, WhiteAcceleration<Motion2>, WhiteJerk<Accel2>, ConstantTurn<Motion2>,
                               MissingDistancePrior, MissingDistanceBall<Point2, Point2>, MissingDistance<Pose2, Point2>,
                               PositionStep<Point2, Point2>, RangeBearing<Point2, Point2>, BearingRay<Point2, Point2>>;

template <class T>
struct Type {
  using type = T;
};

namespace detail {
template <class Visit, class... T>
void for_each_type(std::tuple<T...>*, Visit& visit) {
  (visit(Type<T>{}), ...);
}
}  // namespace detail

template <class List, class Visit>
void for_each_type(Visit visit) {
  detail::for_each_type(static_cast<List*>(nullptr), visit);
}

// ---- random variables of a factor

namespace detail {

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

/// The radius a one-sided factor switches at: well below or well above the distances of the samples.
inline double radius(std::mt19937_64& rng) { return uniform(rng, 0, 1) < 0.7 ? uniform(rng, 1, 3) : uniform(rng, 45, 60); }

template <class V>
V moved_to(const V& x, const Vector<V::space_dim>& p) {
  return x.retract(V::position_jacobian().transpose() * (p - x.position()));
}

template <class V>
std::tuple<V> draw(variables<V>*, std::mt19937_64& rng) {
  return {near_rotation(V{}, 1.5, rng)};
}

template <class A, class B>
std::tuple<A, B> draw(variables<A, B>*, std::mt19937_64& rng) {
  const A a = random_variable<A>(rng);
  B b = random_variable<B>(rng);
  if constexpr (std::is_same_v<A, B>) b = near_rotation(a, 1.5, rng);
  if constexpr (space_dim < A >> 0 && space_dim<A> == space_dim<B>) {
    const Vector<space_dim<A>> offset = uniform(rng, 6, 20) * random_unit<space_dim<A>>(rng);
    b = moved_to(b, a.position() + offset);
  }
  return {a, b};
}

template <class A, class B>
std::tuple<A, B, Scalar> draw(variables<A, B, Scalar>*, std::mt19937_64& rng) {
  return std::tuple_cat(draw(static_cast<variables<A, B>*>(nullptr), rng), std::tuple<Scalar>(radius(rng)));
}

}  // namespace detail

template <class F>
struct RandomVariables {
  static typename F::Variables::Tuple variables(std::mt19937_64& rng) {
    return detail::draw(static_cast<typename F::Variables*>(nullptr), rng);
  }
};

// ---- random factors

template <class F>
struct Sample;

namespace detail {
/// An information matrix; of every four one says nothing of its first component, and one nothing of a direction between all of them.
template <int N>
Matrix<N, N> information(std::mt19937_64& rng) {
  Matrix<N, N> I = random_covariance<N>(rng);
  const Vector<N> silent = random_unit<N>(rng);
  const Matrix<N, N> others = Matrix<N, N>::Identity() - silent * silent.transpose();
  const double kind = uniform(rng, 0, 1);
  if (kind < 0.25) I.row(0).setZero(), I.col(0).setZero();
  if (kind > 0.75) I = others * I * others;
  return 0.5 * (I + I.transpose());
}
}  // namespace detail

template <class V>
struct Sample<Prior<V>> : RandomVariables<Prior<V>> {
  static Prior<V> factor(std::mt19937_64& rng) {
    const V mean = detail::near_rotation(V{}, 1, rng);
    return Prior<V>::from_information(mean, detail::information<V::dim>(rng));
  }
};

template <class V>
struct Sample<Between<V>> : RandomVariables<Between<V>> {
  static Between<V> factor(std::mt19937_64& rng) {
    const V measured = detail::near_rotation(V{}, 1, rng);
    return Between<V>::from_information(measured, detail::information<V::dim>(rng));
  }
};

template <class P, class L>
struct Sample<RelativePoint<P, L>> : RandomVariables<RelativePoint<P, L>> {
  static RelativePoint<P, L> factor(std::mt19937_64& rng) {
    const Vector<P::space_dim> measured = random_vector<P::space_dim>(rng, 5);
    return RelativePoint<P, L>::from_information(measured, detail::information<P::space_dim>(rng));
  }
};

template <class A, class B>
struct Sample<Range<A, B>> : RandomVariables<Range<A, B>> {
  static Range<A, B> factor(std::mt19937_64& rng) { return {uniform(rng, 0, 30), uniform(rng, 0.5, 2)}; }
};

template <class A, class B>
struct Sample<RangeBall<A, B>> : RandomVariables<RangeBall<A, B>> {
  static RangeBall<A, B> factor(std::mt19937_64& rng) { return {detail::radius(rng), uniform(rng, 0.5, 2)}; }
};

template <class A, class B>
struct Sample<MissingDistance<A, B>> : RandomVariables<MissingDistance<A, B>> {
  static MissingDistance<A, B> factor(std::mt19937_64& rng) { return {detail::radius(rng), uniform(rng, 0.5, 2), uniform(rng, 0.5, 2)}; }
};

template <class A, class B>
struct Sample<MissingDistanceBall<A, B>> : RandomVariables<MissingDistanceBall<A, B>> {
  static MissingDistanceBall<A, B> factor(std::mt19937_64& rng) { return {uniform(rng, 0.5, 2)}; }
};

template <>
struct Sample<MissingDistancePrior> : RandomVariables<MissingDistancePrior> {
  static MissingDistancePrior factor(std::mt19937_64& rng) { return {uniform(rng, 0, 20), uniform(rng, 0.5, 2)}; }
};

template <class A, class B>
struct Sample<RangeBearingBall<A, B>> : RandomVariables<RangeBearingBall<A, B>> {
  static RangeBearingBall<A, B> factor(std::mt19937_64& rng) {
    const double distance = detail::radius(rng), sigma = uniform(rng, 0.5, 1);
    const double shift = uniform(rng, 0.2, 1.5);  // σ²κ/d
    return {distance, sigma, random_unit<space_dim<A>>(rng), shift * distance / (sigma * sigma)};
  }
};

template <class A, class B>
struct Sample<VonMisesBearing<A, B>> : RandomVariables<VonMisesBearing<A, B>> {
  static VonMisesBearing<A, B> factor(std::mt19937_64& rng) { return {random_unit<space_dim<A>>(rng), uniform(rng, 1, 100)}; }
};

template <class A, class B>
struct Sample<RangeBearing<A, B>> : RandomVariables<RangeBearing<A, B>> {
  static RangeBearing<A, B> factor(std::mt19937_64& rng) {
    return {uniform(rng, 1, 30), uniform(rng, 0.5, 2), random_unit<space_dim<A>>(rng), uniform(rng, 1, 100)};
  }
};

template <class A, class B>
struct Sample<BearingRay<A, B>> : RandomVariables<BearingRay<A, B>> {
  static BearingRay<A, B> factor(std::mt19937_64& rng) { return {random_unit<space_dim<A>>(rng), uniform(rng, 0.5, 2)}; }
};

template <class P, class B>
struct Sample<VonMisesBearingBody<P, B>> : RandomVariables<VonMisesBearingBody<P, B>> {
  static VonMisesBearingBody<P, B> factor(std::mt19937_64& rng) { return {random_unit<space_dim<P>>(rng), uniform(rng, 1, 100)}; }
};

template <class A, class B>
struct Sample<PositionStep<A, B>> : RandomVariables<PositionStep<A, B>> {
  static PositionStep<A, B> factor(std::mt19937_64& rng) { return {uniform(rng, 0.5, 2)}; }
};

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

template <class V>
struct Sample<WhiteAcceleration<V>> : RandomVariables<WhiteAcceleration<V>> {
  static WhiteAcceleration<V> factor(std::mt19937_64& rng) {
    using F = WhiteAcceleration<V>;
    const double dt = uniform(rng, 0.2, 1);
    const int steps = static_cast<int>(uniform(rng, 1, 6));
    const Matrix<V::dim, V::dim> R = random_covariance<V::dim>(rng);
    const int kind = static_cast<int>(uniform(rng, 0, 4));
    if (kind == 0) return F::continuous(dt, uniform(rng, 0.1, 2));
    if (kind == 1) return F::paper(dt, steps, R);
    if (kind == 2) return F::recursive(dt, steps, R, random_covariance<V::dim>(rng));
    return F::exact(dt, steps, R);
  }
};

template <class V>
struct Sample<WhiteJerk<V>> : RandomVariables<WhiteJerk<V>> {
  static WhiteJerk<V> factor(std::mt19937_64& rng) {
    const double duration = uniform(rng, 0.5, 2);
    return WhiteJerk<V>::continuous(duration, uniform(rng, 0.1, 2));
  }
};

template <>
struct Sample<ConstantTurn<Motion2>> : RandomVariables<ConstantTurn<Motion2>> {
  static ConstantTurn<Motion2> factor(std::mt19937_64& rng) {
    const double dt = uniform(rng, 0.1, 1), omega = uniform(rng, -1, 1);
    return ConstantTurn<Motion2>::from_covariance(dt, omega, random_covariance<4>(rng));
  }
};

}  // namespace holdfast::testing
