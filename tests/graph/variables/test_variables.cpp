// What each variable type is: its name, its memory, its parts. What all have in common as manifolds: test_manifold.cpp.
#include <gtest/gtest.h>

#include <holdfast/graph/values.hpp>
#include <holdfast/testing.hpp>

namespace holdfast {
namespace {

template <class V>
void expect_shape(const char* name, int dim, int ambient, int space) {
  EXPECT_STREQ(V::name(), name);
  EXPECT_EQ(V::dim, dim) << name;
  EXPECT_EQ(ambient_dim<V>, ambient) << name;
  EXPECT_EQ(space_dim<V>, space) << name;
  EXPECT_TRUE(V{}.is_finite()) << name;
}

TEST(Variables, HaveTheirNamesAndSizes) {
  expect_shape<Scalar>("Scalar", 1, 1, 0);
  expect_shape<Point2>("Point2", 2, 2, 2);
  expect_shape<Point3>("Point3", 3, 3, 3);
  expect_shape<Motion2>("Motion2", 4, 4, 2);
  expect_shape<Motion3>("Motion3", 6, 6, 3);
  expect_shape<Accel2>("Accel2", 6, 6, 2);
  expect_shape<Accel3>("Accel3", 9, 9, 3);
  expect_shape<Turning2>("Turning2", 5, 5, 2);
  expect_shape<Pose2>("Pose2", 3, 4, 2);
  expect_shape<Pose3>("Pose3", 6, 7, 3);
}

template <class V>
void expect_sees_non_finite() {
  for (const double bad : {static_cast<double>(NAN), static_cast<double>(INFINITY)})
    for (int i = 0; i < ambient_dim<V>; ++i) {
      V x;
      reinterpret_cast<double*>(&x)[i] = bad;
      EXPECT_FALSE(x.is_finite()) << V::name() << " " << i;
    }
}

TEST(Variables, SeeANonFiniteCoordinateAnywhere) {
  expect_sees_non_finite<Scalar>();
  expect_sees_non_finite<Point3>();
  expect_sees_non_finite<Motion2>();
  expect_sees_non_finite<Accel3>();
  expect_sees_non_finite<Turning2>();
  expect_sees_non_finite<Pose2>();
  expect_sees_non_finite<Pose3>();
}

TEST(Kinematic, IsInterleavedPerAxis) {
  const Motion2 motion(1, 10, 2, 20);
  EXPECT_EQ(motion.position(), Vector<2>(1, 2));
  EXPECT_EQ(motion.derivative(1), Vector<2>(10, 20));
  const Accel3 accel(1, 10, 100, 2, 20, 200, 3, 30, 300);
  EXPECT_EQ(accel.position(), Vector<3>(1, 2, 3));
  EXPECT_EQ(accel.derivative(1), Vector<3>(10, 20, 30));
  EXPECT_EQ(accel.derivative(2), Vector<3>(100, 200, 300));
}

TEST(Turning2, IsAMotionAndItsTurnRate) {
  const Turning2 state(Motion2(1, 10, 2, 20), 0.5);
  EXPECT_EQ(state.value, (Vector<5>() << 1, 10, 2, 20, 0.5).finished());
  EXPECT_EQ(state.motion().value, Vector<4>(1, 10, 2, 20));
  EXPECT_EQ(state.turn_rate(), 0.5);
  EXPECT_EQ(state.position(), Vector<2>(1, 2));
}

TEST(Pose2, ComposesLikeMatrices) {
  std::mt19937_64 rng(1);
  for (int i = 0; i < 20; ++i) {
    const auto a = testing::random_variable<Pose2>(rng), b = testing::random_variable<Pose2>(rng);
    const Vector<2> v = testing::random_vector<2>(rng);
    EXPECT_LT(((a * b).rotation() - a.rotation() * b.rotation()).norm(), 1e-14);
    EXPECT_LT(((a * b).p - (a.p + a.rotation() * b.p)).norm(), 1e-13);
    EXPECT_LT((a.to_world(v) - a.rotation() * v).norm(), 1e-14);
    EXPECT_LT((a.to_body(a.to_world(v)) - v).norm(), 1e-14);
    EXPECT_LT(Pose2{}.local(a * a.inverse()).norm(), 1e-13);
  }
}

TEST(Pose2, AngleIsTheHeading) {
  for (const double angle : {-3.1, -1.0, 0.0, 0.3, 3.1}) EXPECT_NEAR(Pose2(1, 2, angle).angle(), angle, 1e-15);
  EXPECT_NEAR(Pose2(0, 0, 3 * kPi / 2).angle(), -kPi / 2, 1e-15);
}

TEST(Pose3, ComposesLikeMatrices) {
  std::mt19937_64 rng(2);
  for (int i = 0; i < 20; ++i) {
    const auto a = testing::random_variable<Pose3>(rng), b = testing::random_variable<Pose3>(rng);
    const Vector<3> v = testing::random_vector<3>(rng);
    EXPECT_LT(((a * b).rotation() - a.rotation() * b.rotation()).norm(), 1e-14);
    EXPECT_LT(((a * b).p - (a.p + a.rotation() * b.p)).norm(), 1e-13);
    EXPECT_LT((a.to_world(v) - a.rotation() * v).norm(), 1e-14);
    EXPECT_LT((a.to_body(a.to_world(v)) - v).norm(), 1e-14);
    EXPECT_LT(Pose3{}.local(a * a.inverse()).norm(), 1e-12);
  }
}

// Convention: the translation moves in the world frame, the rotation is perturbed on the right (in the body).
TEST(Poses, TranslateInTheWorldAndTurnInTheBody) {
  const Pose2 x(1, 2, kPi / 2);
  EXPECT_EQ(x.retract({1, 0, 0}).p, Vector<2>(2, 2));
  EXPECT_NEAR(x.retract({0, 0, 0.2}).angle(), kPi / 2 + 0.2, 1e-15);
  std::mt19937_64 rng(3);
  const auto y = testing::random_variable<Pose3>(rng);
  const Vector<3> w = testing::random_vector<3>(rng);
  Vector<6> delta;
  delta << 1, 2, 3, w;
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(w.norm(), Eigen::Vector3d(w.normalized())).toRotationMatrix();
  EXPECT_LT((y.retract(delta).p - y.p - Vector<3>(1, 2, 3)).norm(), 1e-13);
  EXPECT_LT((y.retract(delta).rotation() - y.rotation() * turn).norm(), 1e-14);
}

// ---- parts and products

TEST(Variables, OfThePositionHaveCoordinates) {
  EXPECT_EQ(Point2(1, 2).x(), 1);
  EXPECT_EQ(Point2(1, 2).y(), 2);
  const Accel3 motion(1, 2, 3, 4, 5, 6, 7, 8, 9);
  EXPECT_EQ((Vector<3>(motion.x(), motion.y(), motion.z())), motion.position());
}

TEST(Variables, PosesMovePointsFromTheBodyToTheWorld) {
  const Pose2 left(1, 2, kPi / 2);
  EXPECT_TRUE((left * Point2(3, 0)).value.isApprox(Vector<2>(1, 5), 1e-15));
  EXPECT_TRUE((left * Vector<2>(3, 0)).isApprox(Vector<2>(1, 5), 1e-15));
  EXPECT_TRUE((left.inverse() * (left * Point2(3, 4))).value.isApprox(Vector<2>(3, 4), 1e-15));
  const Pose3 up = Pose3::from_roll_pitch_yaw({1, 2, 3}, 0, -kPi / 2, 0);  // x to z
  EXPECT_TRUE((up * Point3(3, 0, 0)).value.isApprox(Vector<3>(1, 2, 6), 1e-15));
  EXPECT_TRUE((up * Vector<3>(3, 0, 0)).isApprox(Vector<3>(1, 2, 6), 1e-15));
  EXPECT_TRUE((up.inverse() * (up * Point3(3, 4, 5))).value.isApprox(Vector<3>(3, 4, 5), 1e-15));
  EXPECT_TRUE(((up * up) * Vector<3>(3, 4, 5)).isApprox(up * (up * Vector<3>(3, 4, 5)), 1e-15));
}

TEST(Variables, RollPitchYawAreTurnsAboutTheWorldsAxesInThisOrder) {
  const Pose3 pose = Pose3::from_roll_pitch_yaw({0, 0, 0}, kPi / 2, 0, kPi / 2);  // y to z by the roll, where it stays; x to y by the yaw
  EXPECT_TRUE((pose * Vector<3>(0, 1, 0)).isApprox(Vector<3>(0, 0, 1), 1e-15));
  EXPECT_TRUE((pose * Vector<3>(1, 0, 0)).isApprox(Vector<3>(0, 1, 0), 1e-15));
  std::mt19937_64 rng(3);
  for (int i = 0; i < 50; ++i) {
    const Vector<3> angles(testing::uniform(rng, -3.1, 3.1), testing::uniform(rng, -1.5, 1.5), testing::uniform(rng, -3.1, 3.1));
    const Pose3 turned = Pose3::from_roll_pitch_yaw({1, 2, 3}, angles[0], angles[1], angles[2]);
    EXPECT_LT((turned.roll_pitch_yaw() - angles).norm(), 1e-13);
  }
  for (double pitch : {kPi / 2, -kPi / 2}) {  // roll and yaw turn about one axis: the rotation is right
    const Pose3 steep = Pose3::from_roll_pitch_yaw({0, 0, 0}, 0.4, pitch, 0.3);
    const Vector<3> angles = steep.roll_pitch_yaw();
    EXPECT_LT(Pose3::from_roll_pitch_yaw({0, 0, 0}, angles[0], angles[1], angles[2]).local(steep).norm(), 1e-7);
  }
}

}  // namespace
}  // namespace holdfast
