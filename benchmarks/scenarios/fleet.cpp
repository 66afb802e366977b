#include <holdfast/benchmarks/scenarios/random.hpp>
#include <holdfast/benchmarks/scenarios/scenario.hpp>
#include <holdfast/factors/between.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/range.hpp>

namespace holdfast::bench {
namespace {

constexpr char kLetters[] = "ABCDEFGHIJKMNOPQRSTUVWXYZ";  // without L, which landmarks have
constexpr double kRangeSigma = 0.1;
const Vector<3> kOdometrySigmas(0.05, 0.05, 0.01);

/// Straight on and a random turn; far out the turn leads back to the middle.
Pose2 next_pose(const Pose2& pose, Random& random) {
  constexpr double kFar = 15, kTurn = 0.2, kBack = 0.5;
  double turn = kTurn * random.normal();
  if (pose.p.norm() > kFar) {
    const Vector<2> to_middle = pose.rotation().transpose() * -pose.p;
    turn += to_middle[1] > 0 ? kBack : -kBack;
  }
  return pose * Pose2(1, 0, turn);
}

Pose2 noisy(const Pose2& pose, Random& random) { return pose.retract(random.normals<3>(1).cwiseProduct(kOdometrySigmas)); }

}  // namespace

Instance fleet(int agents, int steps, unsigned seed) {
  constexpr int kMostAgents = sizeof kLetters - 1, kBeacons = 4;
  if (agents < 1 || agents > kMostAgents) fail<BadOption>("a fleet has 1 to ", kMostAgents, " agents, one a letter, not ", agents);
  if (steps < 2) fail<BadOption>("a fleet needs 2 steps or more, not ", steps);
  Random random(seed);
  const Agent L('L');
  Instance instance;
  std::vector<Vector<2>> beacons;
  for (const double x : {-20, 20})
    for (const double y : {-20, 20}) beacons.emplace_back(x, y);
  for (int b = 0; b < kBeacons; ++b) {
    instance.truth.insert(L(b), Point2(beacons[b]));
    instance.start.insert(L(b), Point2(beacons[b] + random.normals<2>(1)));
  }

  std::vector<Pose2> truth, reckoned;
  for (int a = 0; a < agents; ++a) {
    const Vector<2> p = random.uniforms<2>(-10, 10);
    truth.emplace_back(p[0], p[1], random.uniform(-kPi, kPi));
  }
  const auto measured = [&](const Vector<2>& p, const Vector<2>& q) {
    return std::max(0.0, (q - p).norm() + kRangeSigma * random.normal());
  };
  for (int k = 0; k < steps; ++k) {
    for (int a = 0; a < agents; ++a) {
      const Agent agent(kLetters[a]);
      if (k == 0) {
        reckoned.push_back(noisy(truth[a], random));
        instance.graph.add(Prior<Pose2>::from_sigmas(reckoned[a], kOdometrySigmas), {agent(0)});
      } else {
        const Pose2 next = next_pose(truth[a], random);
        const Pose2 step = noisy(truth[a].inverse() * next, random);
        instance.graph.add(Between<Pose2>::from_sigmas(step, kOdometrySigmas), {agent(k - 1), agent(k)});
        truth[a] = next;
        reckoned[a] = reckoned[a] * step;
      }
      instance.truth.insert(agent(k), truth[a]);
      instance.start.insert(agent(k), reckoned[a]);
      for (int b = 0; b < kBeacons; ++b)
        instance.graph.add(Range<Pose2, Point2>{measured(truth[a].p, beacons[b]), kRangeSigma}, {agent(k), L(b)});
    }
    for (int a = 0; a < agents; ++a)
      for (int c = a + 1; c < agents; ++c)
        instance.graph.add(Range<Pose2, Pose2>{measured(truth[a].p, truth[c].p), kRangeSigma},
                           {Agent(kLetters[a])(k), Agent(kLetters[c])(k)});
  }
  return instance;
}

}  // namespace holdfast::bench
