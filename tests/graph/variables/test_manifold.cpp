// One mathematics for every variable type, at the identity, near it (1e-8) and at random.
#include <gtest/gtest.h>

#include "tests/problems.hpp"

namespace holdfast {
namespace {

using testing::near_identity;
using testing::random_unit;
using testing::random_variable;
using testing::random_vector;

template <class V>
class Manifold : public ::testing::Test {
 protected:
  /// The identity, near it, and anywhere.
  static std::vector<V> samples() {
    std::mt19937_64 rng(11);
    std::vector<V> all{V{}};
    for (int i = 0; i < 5; ++i) all.push_back(near_identity<V>(rng));
    for (int i = 0; i < 10; ++i) all.push_back(random_variable<V>(rng));
    return all;
  }
  /// No rotation of more than π: there local() is the inverse of retract().
  static std::vector<Vector<V::dim>> tangents() {
    std::mt19937_64 rng(12);
    std::vector<Vector<V::dim>> all{Vector<V::dim>::Zero()};
    for (const double size : {1e-12, 1e-8, 1e-5, 1e-4, 1e-3, 0.3, 1.5}) all.push_back(size * random_unit<V::dim>(rng));
    return all;
  }
};

using Types = ::testing::Types<Scalar, Point2, Point3, Motion2, Motion3, Accel2, Accel3, Turning2, Pose2, Pose3>;
TYPED_TEST_SUITE(Manifold, Types);

TYPED_TEST(Manifold, RetractUndoesLocal) {
  using V = TypeParam;
  for (const V& x : this->samples())
    for (const V& y : this->samples()) {
      const V z = x.retract(x.local(y));
      EXPECT_LT(y.local(z).norm(), 1e-13 * (1 + x.local(y).norm()));
    }
}

TYPED_TEST(Manifold, LocalUndoesRetract) {
  for (const TypeParam& x : this->samples())
    for (const auto& delta : this->tangents())
      EXPECT_LT((x.local(x.retract(delta)) - delta).norm(), 1e-14 * (1 + x.local(TypeParam{}).norm()));
}

TYPED_TEST(Manifold, ZeroMovesNothing) {
  using V = TypeParam;
  for (const V& x : this->samples()) {
    EXPECT_LT(x.local(x).norm(), 1e-15);
    EXPECT_LT(x.local(x.retract(Vector<V::dim>::Zero())).norm(), 1e-15);
  }
}

TYPED_TEST(Manifold, AgreesWithItsPool) {
  using V = TypeParam;
  Pool<V> pool;
  for (const V& x : this->samples())
    for (const auto& delta : this->tangents()) {
      const V expected = x.retract(delta);
      V moved;
      pool.retract_ambient(reinterpret_cast<const double*>(&x), delta.data(), reinterpret_cast<double*>(&moved));
      EXPECT_EQ(std::memcmp(&moved, &expected, sizeof(V)), 0);
      Vector<V::dim> back;
      pool.local_ambient(reinterpret_cast<const double*>(&x), reinterpret_cast<const double*>(&moved), back.data());
      EXPECT_EQ(back, x.local(moved));
    }
}

TYPED_TEST(Manifold, CastAndBackIsTheSame) {
  std::mt19937_64 rng(13);
  const auto x = random_variable<TypeParam>(rng);
  EXPECT_EQ(x.local(x.template cast<double>()).norm(), x.local(x).norm());
  EXPECT_LT(x.local(x.template cast<float>().template cast<double>()).norm(), 1e-5);
}

template <class V>
class Positioned : public Manifold<V> {};
using PositionedTypes = ::testing::Types<Point2, Point3, Motion2, Motion3, Accel2, Accel3, Turning2, Pose2, Pose3>;
TYPED_TEST_SUITE(Positioned, PositionedTypes);

TYPED_TEST(Positioned, PositionIsLinearInTheTangent) {
  using V = TypeParam;
  for (const V& x : this->samples())
    for (const auto& delta : this->tangents()) {
      const Vector<V::space_dim> moved = x.position() + V::position_jacobian() * delta;
      EXPECT_LT((x.retract(delta).position() - moved).norm(), 1e-14 * (1 + moved.norm()));
    }
}

template <int Space>
testing::Motion<Space> small_motion(const Vector<Space>& v, const Vector<rotation_dim<Space>>& w) {
  testing::Motion<Space> world{Matrix<Space, Space>::Identity(), v};
  if constexpr (Space == 2)
    world.R = Eigen::Rotation2Dd(w[0]).toRotationMatrix();
  else if (w.norm() > 0)
    world.R = Eigen::AngleAxisd(w.norm(), Eigen::Vector3d(w.normalized())).toRotationMatrix();
  return world;
}

TYPED_TEST(Positioned, RigidMotionIsTheVelocityWhenTheWorldMoves) {
  using V = TypeParam;
  constexpr int n = V::space_dim;
  std::mt19937_64 rng(14);
  constexpr double h = 1e-5;
  for (const V& x : this->samples()) {
    const Vector<n> v = random_vector<n>(rng);
    const Vector<rotation_dim<n>> w = random_vector<rotation_dim<n>>(rng);
    const V ahead = moved(small_motion<n>(h * v, h * w), x), behind = moved(small_motion<n>(-h * v, -h * w), x);
    const Vector<V::dim> numeric = (x.local(ahead) - x.local(behind)) / (2 * h);
    EXPECT_LT((x.rigid_motion(v, w) - numeric).norm(), 1e-8 * (1 + numeric.norm()));
  }
}

TEST(Rotations, StayUnitAfterAHundredThousandSteps) {
  std::mt19937_64 rng(15);
  Pose2 a;
  Pose3 b;
  for (int i = 0; i < 100000; ++i) {
    a = a.retract(random_vector<3>(rng, 0.5));
    b = b.retract(random_vector<6>(rng, 0.5));
  }
  EXPECT_NEAR(a.heading.norm(), 1, 1e-15);
  EXPECT_NEAR(b.q.norm(), 1, 1e-15);
}

// A heading read from a file may be a little off; one step must not lose it.
TEST(Rotations, RetractPullsBackToUnitLength) {
  Pose2 a(Vector<2>(0, 0), Vector<2>(1.0001, 0));
  EXPECT_NEAR(a.retract({0, 0, 0.1}).heading.norm(), 1, 1e-7);
  Pose3 b;
  b.q.coeffs() *= 1.0001;
  EXPECT_NEAR(b.retract(Vector<6>::Constant(0.1)).q.norm(), 1, 1e-7);
}

TEST(So3, LogUndoesExpUpToAHalfTurn) {
  std::mt19937_64 rng(16);
  for (const double angle : {0.0, 1e-12, 1e-8, 1e-5, 0.99e-4, 1.01e-4, 1e-3, 1.0, 3.0, kPi - 1e-3, kPi - 1e-7}) {
    const Vector<3> w = angle * random_unit<3>(rng);
    EXPECT_LT((so3::log<double>(so3::exp<double>(w)) - w).norm(), 4e-15 * (1 + angle)) << angle;
    so3::Quaternion<double> other = so3::exp<double>(w);
    other.coeffs() *= -1;  // the same rotation
    EXPECT_LT((so3::log<double>(other) - w).norm(), 4e-15 * (1 + angle)) << angle;
  }
}

TEST(So3, HalfTurnHasALog) {
  for (int axis = 0; axis < 3; ++axis) {
    const Vector<3> w = kPi * Vector<3>::Unit(axis);
    const Vector<3> log = so3::log<double>(so3::exp<double>(w));
    EXPECT_NEAR(log.norm(), kPi, 1e-14);
    EXPECT_NEAR(std::abs(log[axis]), kPi, 1e-14);
  }
  EXPECT_NEAR(so3::log<double>(so3::Quaternion<double>(0, 0.6, 0.8, 0)).norm(), kPi, 1e-15);
}

TEST(So3, RightJacobianInverseIsTheSlopeOfTheLog) {
  std::mt19937_64 rng(17);
  for (const double angle : {0.0, 1e-8, 1e-4, 0.99e-3, 1.01e-3, 0.1, 1.0, 2.5, 3.1}) {
    const Vector<3> phi = angle * random_unit<3>(rng);
    const auto turned = [&](int k, double h) -> Vector<3> {
      return so3::log<double>(so3::exp<double>(phi) * so3::exp<double>(Vector<3>(h * Vector<3>::Unit(k))));
    };
    constexpr double h = 1e-3;
    Matrix<3, 3> numeric;
    for (int k = 0; k < 3; ++k) {
      const Vector<3> coarse = (turned(k, h) - turned(k, -h)) / (2 * h), fine = (turned(k, h / 2) - turned(k, -h / 2)) / h;
      numeric.col(k) = (4 * fine - coarse) / 3;
    }
    EXPECT_LT((so3::right_jacobian_inverse(phi) - numeric).norm(), 1e-9) << angle;
  }
}

TEST(WrapAngle, LandsInTheHalfOpenTurn) {
  EXPECT_EQ(wrap_angle(0), 0);
  EXPECT_DOUBLE_EQ(wrap_angle(3 * kPi / 2), -kPi / 2);
  EXPECT_DOUBLE_EQ(wrap_angle(-3 * kPi / 2), kPi / 2);
  EXPECT_DOUBLE_EQ(wrap_angle(kPi), kPi);
  EXPECT_DOUBLE_EQ(wrap_angle(-kPi), kPi);
  for (double angle = -50; angle < 50; angle += 0.37) {
    EXPECT_NEAR(std::cos(wrap_angle(angle)), std::cos(angle), 1e-13);
    EXPECT_NEAR(std::sin(wrap_angle(angle)), std::sin(angle), 1e-13);
    EXPECT_LE(std::abs(wrap_angle(angle)), kPi);
  }
}

}  // namespace
}  // namespace holdfast
