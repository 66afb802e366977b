// Your own factor is one struct: it runs in every back-end of this build, and as it is in ceres_add, gtsam_factor, g2o_edge or the graph of
// an MRPT network.
#include <cmath>
#include <holdfast/factors/prior.hpp>
#include <holdfast/graph/autodiff.hpp>
#include <holdfast/solvers/table.hpp>
#include <iostream>
#ifdef HOLDFAST_WITH_GTSAM
#include <holdfast/adapters/gtsam/backend.hpp>
#endif
#ifdef HOLDFAST_WITH_G2O
#include <holdfast/adapters/g2o/backend.hpp>
#endif

using namespace holdfast;

struct WallAhead {            // a laser that looks ahead at the wall x = wall, its Jacobian by hand
  double range, wall, sigma;  // [m]
  using Variables = variables<Pose2>;
  static constexpr int residual_dim = 1;
  Vector<1> operator()(const Pose2& robot, Jacobians<WallAhead>* J = nullptr) const {
    const double cosine = robot.heading[0], ahead = (wall - robot.p[0]) / cosine;
    if (J != nullptr) J->all << -1 / (cosine * sigma), 0, ahead * robot.heading[1] / (cosine * sigma);
    return Vector<1>((ahead - range) / sigma);
  }
};

struct WallResidual {  // the same; AutoDiff<WallResidual> differentiates it
  double range, wall, sigma;
  using Variables = variables<Pose2>;
  static constexpr int residual_dim = 1;
  template <class T>
  VectorT<T, 1> residual(const Pose2T<T>& robot) const {
    return VectorT<T, 1>(((wall - robot.p[0]) / robot.heading[0] - range) / sigma);
  }
};

template <class Factor>
Pose2 pose_found(const std::string& backend, const Factor& factor) {
  const Key robot('x', 0);
  Graph graph;
  Values values;
  values.insert(robot, Pose2(0, 0, 0.2));
  graph.add(Prior<Pose2>::from_sigmas(Pose2(0, 0, 0.2), Vector<3>(0.5, 0.5, 0.1)), {robot});
  graph.add(factor, {robot}, Huber{2});
  make_backend(backend)->solve(graph, values);
  return values.at<Pose2>(robot);
}

int main() {
#ifdef HOLDFAST_WITH_GTSAM
  register_gtsam_backends();
#endif
#ifdef HOLDFAST_WITH_G2O
  register_g2o_backends();
#endif
  const Pose2 expected = pose_found("irls", WallAhead{4, 5, 0.05});
  bool agree = true;
  for (const std::string& backend : backend_names())
    for (const Pose2& found : {pose_found(backend, WallAhead{4, 5, 0.05}), pose_found(backend, AutoDiff<WallResidual>{{4, 5, 0.05}})}) {
      std::cout << backend << ": the robot is at x = " << found.p[0] << " m\n";
      agree = agree && expected.local(found).norm() < 1e-3;
    }
  return agree ? 0 : 1;
}
