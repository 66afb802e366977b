// Two robots drive side by side; each knows its own odometry, and they hear each other's range, sometimes badly wrong. This is
// the README's example.
#include <holdfast/holdfast.hpp>
#include <iostream>

using namespace holdfast;

int main(int argc, char** argv) {
  const Agent A('A'), B('B');
  const Vector<3> start_sigmas(0.01, 0.01, 0.001), step_sigmas(0.05, 0.05, 0.01);  // [m, m, rad]
  Graph graph;
  Values values;
  for (int k = 0; k < 20; ++k) {
    values.insert(A(k), Pose2(k, 0, 0));
    values.insert(B(k), Pose2(k, 4.5, 0));  // a metre off: its start was guessed
    if (k == 0) continue;
    graph.add(Between<Pose2>::from_sigmas(Pose2(1, 0, 0), step_sigmas), {A(k - 1), A(k)});
    graph.add(Between<Pose2>::from_sigmas(Pose2(1, 0, 0), step_sigmas), {B(k - 1), B(k)});
    const double range = k % 5 == 0 ? 30.0 : 3.5;  // every fifth one is an echo
    graph.add(Range<Pose2, Pose2>{range, 0.1}, {A(k), B(k)}, Cauchy{2.0});
  }
  graph.add(Prior<Pose2>::from_sigmas(Pose2(0, 0, 0), start_sigmas), {A(0)});
  graph.add(Prior<Pose2>::from_sigmas(Pose2(0, 4.5, 0), Vector<3>(2, 2, 0.01)), {B(0)});

  for (const Finding& finding : check(graph, values)) std::cout << finding.text << '\n';
  const auto backend = make_backend(argc > 1 ? argv[1] : "irls");  // or "ceres", "nesterov"
  const Summary summary = backend->solve(graph, values);           // start in, answer out; unchanged when it fails
  std::cout << backend->name() << ": " << summary.str() << "\nB19 is " << (values.at<Pose2>(B(19)).p - values.at<Pose2>(A(19)).p).norm()
            << " m from A19\n";
  return summary.usable() ? 0 : 1;
}
