#include <holdfast/benchmarks/scenarios/random.hpp>
#include <holdfast/benchmarks/scenarios/scenario.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/range_ball.hpp>

namespace holdfast::bench {
namespace {

/// Each node is an agent of its own, at its only step.
constexpr Key N(int node) { return Agent('N', static_cast<std::uint64_t>(node))(0); }

/// All pairs nearer than `radius`, and of each node the nearest other one.
std::vector<std::pair<int, int>> neighbours(const std::vector<Vector<2>>& p, double radius) {
  const int size = static_cast<int>(p.size());
  std::vector<std::pair<int, int>> pairs;
  for (int i = 0; i < size; ++i) {
    int nearest = -1;
    bool alone = true;
    for (int j = 0; j < size; ++j) {
      if (j == i) continue;
      const double distance = (p[j] - p[i]).norm();
      if (nearest < 0 || distance < (p[nearest] - p[i]).norm()) nearest = j;
      if (distance >= radius) continue;
      alone = false;
      if (i < j) pairs.emplace_back(i, j);
    }
    if (alone && nearest >= 0) pairs.emplace_back(i, nearest);
  }
  return pairs;
}

}  // namespace

Instance swarm(int nodes, unsigned seed) {
  constexpr double kSigma = 0.5, kAnchorSigma = 0.1;
  Random random(seed);
  const double side = 10 * std::sqrt(nodes);
  const double radius = 10 * std::sqrt(8 / kPi);
  std::vector<Vector<2>> truth(nodes);
  for (Vector<2>& p : truth) p = random.uniforms<2>(0, side);

  Instance instance;
  for (int i = 0; i < nodes; ++i) {
    instance.truth.insert(N(i), Point2(truth[i]));
    instance.start.insert(N(i), Point2(random.uniforms<2>(0, side)));
    if (i >= (nodes + 9) / 10) continue;
    const Point2 measured(truth[i] + random.normals<2>(kAnchorSigma));
    instance.graph.add(Prior<Point2>::from_sigmas(measured, Vector<2>::Constant(kAnchorSigma)), {N(i)});
  }
  for (const auto& [i, j] : neighbours(truth, radius)) {
    const double distance = std::max(0.0, (truth[j] - truth[i]).norm() + kSigma * random.normal());
    instance.graph.add(RangeBall<Point2, Point2>{distance, kSigma}, {N(i), N(j)});
  }
  return instance;
}

}  // namespace holdfast::bench
