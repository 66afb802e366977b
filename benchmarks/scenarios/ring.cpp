#include <holdfast/benchmarks/scenarios/random.hpp>
#include <holdfast/benchmarks/scenarios/scenario.hpp>
#include <holdfast/factors/between.hpp>
#include <holdfast/factors/prior.hpp>

namespace holdfast::bench {
namespace {

/// As a sensor with these sigmas sees it.
Pose2 noisy(const Pose2& T, const Vector<3>& sigmas, Random& random) {
  const Vector<3> noise = random.normals<3>(1).cwiseProduct(sigmas);
  return {T.p[0] + noise[0], T.p[1] + noise[1], T.angle() + noise[2]};
}

}  // namespace

Instance ring(int poses, const Loss& loss, unsigned seed, double false_share) {
  constexpr double kRadius = 50;
  constexpr Agent A('A');
  const Vector<3> odometry_sigmas(0.05, 0.05, 0.002), closure_sigmas(0.3, 0.3, 0.05);
  Random random(seed);
  std::vector<Pose2> truth;
  for (int k = 0; k < poses; ++k) {
    const double angle = 4 * kPi * k / poses;
    truth.emplace_back(kRadius * std::cos(angle), kRadius * std::sin(angle), angle + kPi / 2);
  }

  Instance instance;
  instance.graph.add(Prior<Pose2>::from_sigmas(truth[0], odometry_sigmas), {A(0)});
  Pose2 reckoned = truth[0];
  for (int k = 0; k < poses; ++k) {
    if (k > 0) {
      const Pose2 step = noisy(truth[k - 1].inverse() * truth[k], odometry_sigmas, random);
      instance.graph.add(Between<Pose2>::from_sigmas(step, odometry_sigmas), {A(k - 1), A(k)});
      reckoned = reckoned * step;
    }
    instance.start.insert(A(k), reckoned);
    instance.truth.insert(A(k), truth[k]);
  }
  for (int k = 0; k + poses / 2 < poses; k += 5) {
    int from = k, to = k + poses / 2;
    Pose2 seen = noisy(truth[from].inverse() * truth[to], closure_sigmas, random);
    if (random.chance(false_share)) {  // two places that look alike
      from = random.index(poses);
      to = (from + 1 + random.index(poses - 1)) % poses;
      seen = noisy(Pose2{}, closure_sigmas, random);
    }
    instance.graph.add(Between<Pose2>::from_sigmas(seen, closure_sigmas), {A(from), A(to)}, loss);
  }
  return instance;
}

}  // namespace holdfast::bench
