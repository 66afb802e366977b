// A user's own factor, its Jacobian by hand and by automatic differentiation: it runs in every back-end and foreign library as ours do.
#include <gtest/gtest.h>

#include <holdfast/graph/autodiff.hpp>
#include <holdfast/testing.hpp>

#include "tests/conforms.hpp"

namespace holdfast {
namespace {

/// The height of a landmark above the robot's own plane.
struct Height {
  double height, sigma;  // [m]
  using Variables = variables<Pose3, Point3>;
  static constexpr int residual_dim = 1;
  static constexpr auto fields() { return std::tuple(field("height", &Height::height), field("sigma", &Height::sigma)); }
  Vector<1> operator()(const Pose3& robot, const Point3& landmark, Jacobians<Height>* J = nullptr) const {
    const Vector<3> p = robot.to_body(landmark.value - robot.p), up = robot.rotation().col(2);
    if (J != nullptr) J->all << -up.transpose(), -p[1], p[0], 0, up.transpose();
    if (J != nullptr) J->all /= sigma;
    return Vector<1>((p[2] - height) / sigma);
  }
};

struct HeightResidual {
  double height, sigma;  // [m]
  using Variables = variables<Pose3, Point3>;
  static constexpr int residual_dim = 1;
  static constexpr auto fields() { return std::tuple(field("height", &HeightResidual::height), field("sigma", &HeightResidual::sigma)); }
  template <class T>
  VectorT<T, 1> residual(const Pose3T<T>& robot, const Point3T<T>& landmark) const {
    return VectorT<T, 1>((robot.to_body((landmark.value - robot.p).eval())[2] - height) / sigma);
  }
};

TEST(YourOwnFactor, HasTheSameJacobianByHandAndByAutomaticDifferentiation) {
  std::mt19937_64 rng(1);
  for (int i = 0; i < 10; ++i) {
    const auto robot = testing::random_variable<Pose3>(rng);
    const auto landmark = testing::random_variable<Point3>(rng);
    Jacobians<Height> by_hand;
    Jacobians<AutoDiff<HeightResidual>> automatic;
    const Vector<1> r = Height{2, 0.5}(robot, landmark, &by_hand);
    EXPECT_NEAR((AutoDiff<HeightResidual>{{2, 0.5}})(robot, landmark, &automatic)[0], r[0], 1e-12 * (1 + std::abs(r[0])));
    EXPECT_LT((by_hand.all - automatic.all).norm(), 1e-12 * by_hand.all.norm());
  }
}

}  // namespace
}  // namespace holdfast

HOLDFAST_CONFORMS(Height, AutoDiff<HeightResidual>);
