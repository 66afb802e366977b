#include <holdfast/benchmarks/random.hpp>
#include <holdfast/benchmarks/scenario.hpp>
#include <holdfast/factors/range_bearing_ball.hpp>
#include <holdfast/factors/white_acceleration.hpp>

namespace holdfast::bench {
namespace {

constexpr int kSteps = 50, kAnchors = 3, kNodes = 3;
constexpr double kSide = 30;  // of the anchors' triangle [m]
constexpr double kSigma = 0.5, kKappa = 6000;
constexpr double kDensity = 0.1;  // of the nodes' acceleration [m²/s³]; a step takes a second

Key node(int i, int step) { return {static_cast<char>('A' + i), static_cast<std::uint64_t>(step)}; }
Key anchor(int i, int step) { return {'L', static_cast<std::uint64_t>(step * kAnchors + i)}; }

/// Loses a share of the measurements of one edge, never two in a row.
class Channel {
 public:
  /// After a loss the next one always arrives: losing with chance q otherwise loses q / (1 + q) of all.
  explicit Channel(double lost) : chance_(lost / (1 - lost)) {}
  bool receives(Random& random) {
    received_ = !(received_ && random.chance(chance_));
    return received_;
  }

 private:
  double chance_;
  bool received_ = true;
};

/// A measured range and direction, as the one convex factor of both.
template <class A, class B>
RangeBearingBall<A, B> measured(const Vector<2>& x, Random& random) {
  const double distance = std::max(0.1, x.norm() + kSigma * random.normal());
  const double angle = std::atan2(x[1], x[0]) + random.normal() / std::sqrt(kKappa);  // von Mises is normal at this concentration
  return {distance, kSigma, Vector<2>(std::cos(angle), std::sin(angle)), kKappa};
}

Vector<2> corner(int i) {
  return kSide / std::sqrt(3) * Vector<2>(std::cos(kPi / 2 + 2 * kPi * i / 3), std::sin(kPi / 2 + 2 * kPi * i / 3));
}

}  // namespace

Instance formation(double lost, unsigned seed) {
  Random random(seed);
  const Vector<2> velocity(2, 0.4);
  std::vector<Vector<2>> place;
  for (int i = 0; i < kNodes; ++i) place.push_back(corner(i) / 3 + random.normals<2>(1));
  std::vector<Channel> channels(kNodes * (kAnchors + kNodes), Channel(lost));
  const auto motion = WhiteAcceleration<Motion2>::continuous(1, kDensity);

  Instance instance;
  for (int k = 0; k < kSteps; ++k) {
    const Vector<2> moved = k * velocity;
    for (int a = 0; a < kAnchors; ++a) {
      instance.start.insert(anchor(a, k), Point2((corner(a) + moved).eval()));
      instance.graph.fix(anchor(a, k));
    }
    for (int i = 0; i < kNodes; ++i) {
      instance.truth.insert(node(i, k), Motion2(place[i][0] + moved[0], velocity[0], place[i][1] + moved[1], velocity[1]));
      instance.start.insert(node(i, k), Motion2(moved[0], 0.0, moved[1], 0.0));
      if (k > 0) instance.graph.add(motion, {node(i, k - 1), node(i, k)});
      Channel* channel = &channels[i * (kAnchors + kNodes)];
      for (int a = 0; a < kAnchors; ++a)
        if (channel[a].receives(random))
          instance.graph.add(measured<Motion2, Point2>(corner(a) - place[i], random), {node(i, k), anchor(a, k)});
      for (int j = i + 1; j < kNodes; ++j)
        if (channel[kAnchors + j].receives(random))
          instance.graph.add(measured<Motion2, Motion2>(place[j] - place[i], random), {node(i, k), node(j, k)});
    }
  }
  return instance;
}

}  // namespace holdfast::bench
