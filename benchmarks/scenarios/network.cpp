#include <holdfast/benchmarks/scenarios/random.hpp>
#include <holdfast/benchmarks/scenarios/scenario.hpp>
#include <holdfast/factors/range_ball.hpp>

namespace holdfast::bench {
namespace {

/// All pairs nearer than `radius`, by a grid of cells of that size.
std::vector<std::pair<int, int>> pairs_within(const std::vector<Vector<2>>& p, double side, double radius) {
  const int cells = std::max(1, static_cast<int>(side / radius));
  const double width = side / cells;
  const auto cell_of = [&](double x) { return std::min(cells - 1, static_cast<int>(x / width)); };
  std::vector<std::vector<int>> in_cell(static_cast<std::size_t>(cells) * cells);
  for (std::size_t i = 0; i < p.size(); ++i)
    in_cell[static_cast<std::size_t>(cell_of(p[i].x())) * cells + cell_of(p[i].y())].push_back(static_cast<int>(i));
  std::vector<std::pair<int, int>> pairs;
  for (int i = 0; i < static_cast<int>(p.size()); ++i) {
    const int cx = cell_of(p[i].x()), cy = cell_of(p[i].y());
    for (int x = std::max(0, cx - 1); x <= std::min(cells - 1, cx + 1); ++x)
      for (int y = std::max(0, cy - 1); y <= std::min(cells - 1, cy + 1); ++y)
        for (const int j : in_cell[static_cast<std::size_t>(x) * cells + y])
          if (i < j && (p[j] - p[i]).norm() < radius) pairs.emplace_back(i, j);
  }
  return pairs;
}

}  // namespace

Instance network(int nodes, unsigned seed) {
  constexpr double kDegree = 8, kNoise = 0.02, kAnchors = 0.1;
  Random random(seed);
  const double side = std::sqrt(nodes), radius = std::sqrt(kDegree / kPi), sigma = kNoise * radius;
  std::vector<Vector<2>> truth(nodes);
  for (Vector<2>& p : truth) p = random.uniforms<2>(0, side);
  const int anchors = std::max(3, static_cast<int>(kAnchors * nodes));
  Vector<2> centroid = Vector<2>::Zero();
  for (int i = 0; i < anchors; ++i) centroid += truth[i] / anchors;
  Instance instance;
  const auto N = [](int node) { return Agent('N', static_cast<std::uint64_t>(node))(0); };
  for (int i = 0; i < nodes; ++i) {
    instance.truth.insert(N(i), Point2(truth[i]));
    instance.start.insert(N(i), Point2(i < anchors ? truth[i] : centroid));
    if (i < anchors) instance.graph.fix(N(i));
  }
  for (const auto& [i, j] : pairs_within(truth, side, radius)) {
    const double distance = (truth[j] - truth[i]).norm() * (1 + kNoise * random.normal());
    if (j >= anchors) instance.graph.add(RangeBall<Point2, Point2>{std::max(0.0, distance), sigma}, {N(i), N(j)});
  }
  return instance;
}

}  // namespace holdfast::bench
