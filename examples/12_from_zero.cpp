// The program of the tutorial (docs/tutorial.md): two robots that know their own steps and hear each other's range. Where the second one
// began is found from the ranges, though every fifth of them is an echo.
#include <holdfast/holdfast.hpp>
#include <iostream>

using namespace holdfast;

int main() {
  const Agent A('A'), B('B');
  Graph graph;
  Values values;

  values.insert(A(0), Pose2(0, 0, 0));
  values.insert(B(0), Pose2(1.5, 5, -0.5));  // guessed: it is at (2, 6)
  graph.add(Prior<Pose2>::from_sigmas(Pose2(0, 0, 0), Vector<3>(0.01, 0.01, 0.001)), {A(0)});
  graph.add(Prior<Pose2>::from_sigmas(Pose2(1.5, 5, -0.5), Vector<3>(3, 3, 0.01)), {B(0)});

  const Pose2 step(1, 0, 0);
  for (int k = 1; k < 20; ++k) {
    for (const Agent& robot : {A, B}) {
      values.insert(robot(k), values.at<Pose2>(robot(k - 1)) * step);
      graph.add(Between<Pose2>::from_sigmas(step, Vector<3>(0.05, 0.05, 0.01)), {robot(k - 1), robot(k)});
    }
  }

  for (int k = 0; k < 20; ++k) {
    const double distance = std::hypot(2 + k * std::cos(0.5) - k, 6 - k * std::sin(0.5));
    const double heard = k % 5 == 3 ? distance + 20 : distance;  // every fifth came by way of a wall
    graph.add(Range<Pose2, Pose2>{heard, 0.1}, {A(k), B(k)}, one_sided(Cauchy{2}));
  }

  for (const Finding& finding : check(graph, values)) std::cout << finding.text << '\n';  // says nothing: nothing is wrong
  const Summary summary = make_backend("irls")->solve(graph, values);
  std::cout << "B0 is at " << values.at<Pose2>(B(0)).p.transpose() << '\n';

  const Matrix<3, 3> covariance = Marginals(graph, values).covariance<Pose2>(B(0));
  std::cout << "known to " << std::sqrt(covariance(0, 0)) << " m and " << std::sqrt(covariance(1, 1)) << " m\n";

  const bool found = (values.at<Pose2>(B(0)).p - Vector<2>(2, 6)).norm() < 0.05;
  return summary.usable() && found ? 0 : 1;
}
