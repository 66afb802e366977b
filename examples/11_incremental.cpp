// The whole history of a robot, updated in place at every step: Incremental.
#include <holdfast/factors/between.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/solvers/incremental/incremental.hpp>
#include <iostream>

using namespace holdfast;

int main() {
  constexpr Agent x('x');
  const Vector<3> sigmas(0.05, 0.05, 0.02);  // [m, m, rad]
  const Pose2 step(1, 0, 0.3);               // a circle, seen a little too tight
  Incremental smoother;
  smoother.insert(x(0), Pose2());
  smoother.add(Prior<Pose2>::from_sigmas(Pose2(), sigmas), {x(0)});
  for (int k = 1; k <= 20; ++k) {
    smoother.insert(x(k), smoother.at<Pose2>(x(k - 1)) * step);
    smoother.add(Between<Pose2>::from_sigmas(step, sigmas), {x(k - 1), x(k)});
    if (k == 20) smoother.add(Between<Pose2>::from_sigmas(Pose2(0.1, 0, 6.0), sigmas), {x(0), x(k)}, Huber{2});  // home again
    const IncrementalStep& update = smoother.update();
    if (k % 10 == 0) std::cout << "step " << k << ": " << update.eliminated << " variables eliminated again\n";
  }
  smoother.finish();
  const Eigen::MatrixXd covariance = smoother.covariance({x(20)});
  std::cout << "x20 at " << smoother.at<Pose2>(x(20)).p.transpose() << ", sigma " << std::sqrt(covariance(0, 0)) << " m, cost "
            << smoother.cost() << '\n';
  return smoother.at<Pose2>(x(20)).p.norm() < 1 ? 0 : 1;
}
