#include <cmath>
#include <holdfast/factors/range_ball.hpp>
#include <holdfast/graph/detail/random.hpp>
#include <holdfast/program/spread_network.hpp>

namespace holdfast::program {
namespace {

constexpr double kDegree = 8, kNoise = 0.02, kAnchors = 0.1;

std::uint64_t mixed(std::uint64_t x) {  // splitmix64
  x += 0x9E3779B97F4A7C15ull;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ull;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBull;
  return x ^ (x >> 31);
}

struct Node {
  std::int64_t id;
  Vector<2> p;
  bool anchor;
};

/// The cells of the whole square; any of them can be drawn for itself.
class Cells {
 public:
  Cells(std::int64_t nodes, unsigned seed)
      : nodes_(nodes),
        seed_(seed),
        radius_(std::sqrt(kDegree / kPi)),
        side_(std::sqrt(static_cast<double>(nodes))),
        across_(std::max<std::int64_t>(1, static_cast<std::int64_t>(side_ / radius_))),
        width_(side_ / static_cast<double>(across_)) {}

  std::int64_t across() const { return across_; }
  double radius() const { return radius_; }
  double side() const { return side_; }
  Vector<2> middle(std::int64_t x, std::int64_t y) const {
    return Vector<2>(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5) * width_;
  }

  std::vector<Node> draw(std::int64_t x, std::int64_t y) const {
    std::vector<Node> nodes;
    if (x < 0 || y < 0 || x >= across_ || y >= across_) return nodes;
    const std::int64_t cell = x * across_ + y, first = first_of(cell), last = first_of(cell + 1);
    std::mt19937_64 engine(mixed(seed_ ^ mixed(static_cast<std::uint64_t>(cell))));
    for (std::int64_t id = first; id < last; ++id) {
      const double u = detail::uniform(engine), v = detail::uniform(engine);
      const Vector<2> p = Vector<2>(static_cast<double>(x) + u, static_cast<double>(y) + v) * width_;
      nodes.push_back({id, p, detail::uniform(engine) < kAnchors});
    }
    return nodes;
  }

  double noise(const Node& a, const Node& b) const {
    std::mt19937_64 engine(
        mixed(mixed(static_cast<std::uint64_t>(a.id)) ^ static_cast<std::uint64_t>(b.id) ^ (std::uint64_t{seed_} << 40)));
    return detail::normal(engine);
  }

 private:
  std::int64_t first_of(std::int64_t cell) const {
    if (cell == across_ * across_) return nodes_;  // which rounding might miss by one
    const auto share = static_cast<long double>(nodes_) / static_cast<long double>(across_ * across_);
    return static_cast<std::int64_t>(share * static_cast<long double>(cell));
  }

  std::int64_t nodes_;
  unsigned seed_;
  double radius_, side_;
  std::int64_t across_;
  double width_;
};

Key key_of(std::int64_t id) {
  const auto bits = static_cast<std::uint64_t>(id);
  return Agent('N', bits % (Agent::kMostNumber + 1))(bits / (Agent::kMostNumber + 1));
}

struct Rectangle {
  std::int64_t x0, x1, y0, y1;
};

Rectangle of_process(std::int64_t across, int rank, int size) {
  int columns = 1;
  for (int n = 1; n * n <= size; ++n)
    if (size % n == 0) columns = n;
  const int rows = size / columns, column = rank % columns, row = rank / columns;
  return {across * row / rows, across * (row + 1) / rows, across * column / columns, across * (column + 1) / columns};
}

}  // namespace

SpreadNetwork spread_network(std::int64_t nodes, unsigned seed, bool near_anchors, int rank, int size) {
  const Cells cells(nodes, seed);
  const Rectangle mine = of_process(cells.across(), rank, size);
  const std::int64_t width = mine.y1 - mine.y0 + 2;
  std::vector<std::vector<Node>> drawn;
  for (std::int64_t x = mine.x0 - 1; x <= mine.x1; ++x)
    for (std::int64_t y = mine.y0 - 1; y <= mine.y1; ++y) drawn.push_back(cells.draw(x, y));
  const auto at = [&](std::int64_t x, std::int64_t y) -> const std::vector<Node>& {
    return drawn[static_cast<std::size_t>((x - mine.x0 + 1) * width + y - mine.y0 + 1)];
  };
  const double sigma = kNoise * cells.radius();
  SpreadNetwork network;
  for (std::int64_t x = mine.x0; x < mine.x1; ++x)
    for (std::int64_t y = mine.y0; y < mine.y1; ++y) {
      Vector<2> heard = Vector<2>::Zero();
      int anchors = 0;
      for (std::int64_t u = x - 1; u <= x + 1; ++u)
        for (std::int64_t v = y - 1; v <= y + 1; ++v)
          for (const Node& other : at(u, v))
            if (other.anchor) {
              heard += other.p;
              ++anchors;
            }
      Vector<2> start = Vector<2>::Constant(cells.side() / 2);
      if (near_anchors) start = anchors > 0 ? Vector<2>(heard / anchors) : cells.middle(x, y);
      for (const Node& a : at(x, y)) {
        network.values.insert(key_of(a.id), Point2(a.anchor ? a.p : start));
        if (a.anchor) network.graph.fix(key_of(a.id));
        for (std::int64_t u = x - 1; u <= x + 1; ++u)
          for (std::int64_t v = y - 1; v <= y + 1; ++v)
            for (const Node& b : at(u, v)) {
              if (b.id <= a.id || (a.anchor && b.anchor)) continue;
              const double distance = (a.p - b.p).norm();
              if (distance >= cells.radius()) continue;
              const double measured = std::max(0.0, distance * (1 + kNoise * cells.noise(a, b)));
              network.graph.add(RangeBall<Point2, Point2>{measured, sigma}, {key_of(a.id), key_of(b.id)});
            }
      }
    }
  return network;
}

}  // namespace holdfast::program
