// A robot drives a figure of eight among four UWB anchors. Its antenna is 0.3 m ahead of it, and every anchor measures 0.15 m too long:
// both are found along with the path, and are 0 at the start.
#include <holdfast/factors/antenna_range_with_lever.hpp>
#include <holdfast/factors/between.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/graph/graph.hpp>
#include <holdfast/solvers/irls/irls.hpp>
#include <iostream>
#include <random>

int main() {
  using namespace holdfast;
  constexpr int poses = 200, anchors = 4;
  const Vector<2> true_lever(0.3, 0);
  const double true_bias = 0.15;  // [m]
  const Point2 places[anchors]{{-8, -8}, {8, -8}, {8, 8}, {-8, 8}};
  const auto truth = [](int k) {
    const double t = 4 * kPi * k / poses;
    return Pose2(5 * std::sin(t), 2.5 * std::sin(2 * t), std::atan2(std::cos(2 * t), std::cos(t)));
  };

  std::mt19937_64 rng(1);
  std::normal_distribution<double> normal;
  const Agent A('A'), L('L'), B('B');  // poses, anchors, biases
  const Key lever('l', 0);
  Graph graph;
  Values values;
  values.insert(lever, Point2(0, 0));
  graph.add(Prior<Point2>::from_sigmas({0, 0}, {1, 1}), {lever});
  for (int l = 0; l < anchors; ++l) {
    values.insert(L(l), places[l]);
    graph.fix(L(l));
    values.insert(B(l), Scalar(0));
    graph.add(Prior<Scalar>::from_sigmas(0, Vector<1>(1)), {B(l)});
  }
  values.insert(A(0), truth(0));
  for (int k = 0; k < poses; ++k) {
    if (k > 0) {
      const Vector<3> noise(0.01 * normal(rng), 0.01 * normal(rng), 0.002 * normal(rng));
      const Pose2 step = (truth(k - 1).inverse() * truth(k)).retract(noise);
      graph.add(Between<Pose2>::from_sigmas(step, {0.01, 0.01, 0.002}), {A(k - 1), A(k)});
      values.insert(A(k), values.at<Pose2>(A(k - 1)) * step);  // dead reckoning
    }
    for (int l = 0; l < anchors; ++l) {
      const double measured = (truth(k) * true_lever - places[l].value).norm() + true_bias + 0.05 * normal(rng);
      graph.add(AntennaRangeWithLever<Pose2, Point2>{measured, 0.05}, {A(k), L(l), lever, B(l)});
    }
  }

  const Summary summary = Irls().solve(graph, values);
  std::cout << summary << "\nlever arm " << values.at<Point2>(lever).value.transpose() << " m\n";
  bool found = summary.usable() && (values.at<Point2>(lever).value - true_lever).norm() < 0.03;
  for (int l = 0; l < anchors; ++l) {
    std::cout << "bias of " << L(l) << ' ' << values.at<Scalar>(B(l)).value << " m\n";
    found = found && std::abs(values.at<Scalar>(B(l)).value - true_bias) < 0.03;
  }
  return found ? 0 : 1;
}
