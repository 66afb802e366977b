// A user's own factor, its Jacobian by hand and by automatic differentiation: they go through every host as ours do.
#include <holdfast/graph/autodiff.hpp>

#include "tests/draws/draws_of.hpp"

namespace holdfast::testing {

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

template <>
struct Sample<Height> : RandomVariables<Height> {
  static Height factor(std::mt19937_64& rng) { return {uniform(rng, -5, 5), uniform(rng, 0.5, 2)}; }
};
template <>
struct Sample<AutoDiff<HeightResidual>> : RandomVariables<AutoDiff<HeightResidual>> {
  static AutoDiff<HeightResidual> factor(std::mt19937_64& rng) { return {{uniform(rng, -5, 5), uniform(rng, 0.5, 2)}}; }
};

std::vector<Draw> own_draws(std::mt19937_64& rng) { return draws_of<std::tuple<Height, AutoDiff<HeightResidual>>>(rng); }

}  // namespace holdfast::testing
