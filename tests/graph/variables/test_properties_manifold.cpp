// Laws of the variables' manifolds at any rotation, and positions up to 10⁷ m from the origin.
#include "tests/problems.hpp"
#include "tests/properties.hpp"

namespace holdfast {
namespace {

using properties::any_rng;
using properties::decades;

/// Anywhere within `far` of the origin, turned anyhow, by several turns.
template <class V>
V anywhere(std::mt19937_64& rng, double far) {
  Vector<V::dim> delta = testing::random_vector<V::dim>(rng, 10);
  if constexpr (space_dim < V >> 0 && V::dim > space_dim<V>)
    delta.template head<space_dim<V>>() *= far;
  else
    delta *= far;
  return V{}.retract(delta);
}

/// A step whose rotation is less than half a turn.
template <class V>
Vector<V::dim> any_step(std::mt19937_64& rng) {
  return testing::random_unit<V::dim>(rng) * std::min(decades(-12, 1), 0.999 * kPi);
}

template <class V>
void expect_laws() {
  std::mt19937_64 rng = any_rng();
  const double far = decades(-3, 7), rounding = 1e-13 * (1 + 10 * far);
  const V x = anywhere<V>(rng, far), y = anywhere<V>(rng, far);
  const Vector<V::dim> step = any_step<V>(rng);
  RC_ASSERT((x.local(x.retract(step)) - step).norm() <= rounding);
  RC_ASSERT(y.local(x.retract(x.local(y))).norm() <= rounding);
  RC_ASSERT(x.local(x).norm() <= rounding);
  RC_ASSERT((x.local(y).norm() == 0) == (y.local(x).norm() == 0));
}

RC_GTEST_PROP(ManifoldProperties, LocalAndRetractUndoEachOther, ()) {
  expect_laws<Point2>();
  expect_laws<Point3>();
  expect_laws<Motion2>();
  expect_laws<Accel3>();
  expect_laws<Pose2>();
  expect_laws<Pose3>();
}

template <class V>
void expect_group() {
  std::mt19937_64 rng = any_rng();
  const double far = decades(-3, 7), rounding = 1e-13 * (1 + 100 * far);
  const V a = anywhere<V>(rng, far), b = anywhere<V>(rng, far), c = anywhere<V>(rng, far);
  RC_ASSERT(((a * b) * c).local(a * (b * c)).norm() <= rounding);
  RC_ASSERT((a * a.inverse()).local(V{}).norm() <= rounding);
  RC_ASSERT((a * V{}).local(a).norm() <= rounding);
  RC_ASSERT(((a * b).inverse()).local(b.inverse() * a.inverse()).norm() <= rounding);
  const auto p = testing::random_vector<V::space_dim>(rng, far);
  RC_ASSERT((a.to_body(a.to_world(p)) - p).norm() <= rounding);
  RC_ASSERT((a.rotation() * p - a.to_world(p)).norm() <= rounding);
}

RC_GTEST_PROP(ManifoldProperties, PosesAreAGroup, ()) {
  expect_group<Pose2>();
  expect_group<Pose3>();
}

RC_GTEST_PROP(ManifoldProperties, SpinsAddUpBeyondHalfATurn, ()) {  // many small turns are one large one
  const double turn = *rc::gen::inRange(-4000, 4001).as("turn [mrad]") * 1e-3;
  const int steps = *rc::gen::inRange(1, 200).as("steps");
  Pose2 plane;
  Pose3 space;
  for (int i = 0; i < steps; ++i) {
    plane = plane.retract({0, 0, turn});
    space = space.retract((Vector<6>() << 0, 0, 0, 0, 0, turn).finished());
  }
  const double expected = wrap_angle(turn * steps);
  RC_ASSERT(std::abs(wrap_angle(plane.angle() - expected)) <= 1e-12 * steps);
  RC_ASSERT(std::abs(wrap_angle(so3::log<double>(space.q)[2] - expected)) <= 1e-12 * steps);
}

}  // namespace
}  // namespace holdfast
