#include <algorithm>
#include <array>
#include <holdfast/benchmarks/scenarios/random.hpp>
#include <holdfast/benchmarks/suites/suites.hpp>
#include <holdfast/factors/between.hpp>
#include <map>

namespace holdfast::bench {
namespace {

/// Where the walk may go: as many poses a cell whatever the number of poses, so that graphs of all sizes are of one kind.
template <class Pose>
struct Building {
  explicit Building(int poses) {
    constexpr int kPosesACell = 3, kFloors = 3;
    constexpr int floors = Pose::space_dim == 2 ? 1 : kFloors;
    size.setConstant(std::max(2.0, std::round(std::sqrt(poses / (kPosesACell * floors)))));
    if (Pose::space_dim == 3) size[Pose::space_dim - 1] = kFloors;
  }
  bool holds(const Vector<Pose::space_dim>& p) const { return (p.array() >= 0).all() && (p.array() < size.array()).all(); }

  Vector<Pose::space_dim> size;
};

/// The pose after the next step: a quarter turn about a random body axis, or none, and 1 m ahead; on the grid to the last bit.
template <class Pose>
Pose next_on_grid(const Pose& pose, const Building<Pose>& building, Random& random) {
  for (;;) {
    Vector<Pose::dim> turn = Vector<Pose::dim>::Zero();
    if (random.chance(0.3)) {
      const double quarter = random.chance(0.5) ? kPi / 2 : -kPi / 2;
      turn[Pose::space_dim == 2 ? 2 : 4 + random.index(2)] = quarter;  // roll leads nowhere
    }
    Pose next = pose.retract(turn);
    next.p = (next.p + next.to_world(Vector<Pose::space_dim>::Unit(0))).array().round();
    if (building.holds(next.p)) return next;
  }
}

template <class Pose>
Pose noisy(const Pose& pose, double sigma_position, double sigma_rotation, Random& random) {
  Vector<Pose::dim> noise = random.normals<Pose::dim>(sigma_rotation);
  noise.template head<Pose::space_dim>() *= sigma_position / sigma_rotation;
  return pose.retract(noise);
}

template <class Pose>
Instance walk(int poses, unsigned seed) {
  constexpr double kMetres = 0.05, kRadians = 0.02;
  constexpr Agent x('x');
  const Building<Pose> building(poses);
  Random random(seed);
  Vector<Pose::dim> sigmas = Vector<Pose::dim>::Constant(kRadians);
  sigmas.template head<Pose::space_dim>().setConstant(kMetres);
  std::vector<Pose> truth;
  std::map<std::array<int, Pose::space_dim>, std::vector<int>> visits;
  Instance instance;
  const auto see = [&](int from, int to) {
    const Pose measured = noisy<Pose>(truth[from].inverse() * truth[to], kMetres, kRadians, random);
    instance.graph.add(Between<Pose>::from_sigmas(measured, sigmas), {x(from), x(to)});
  };
  for (int k = 0; k < poses; ++k) {
    truth.push_back(k == 0 ? Pose() : next_on_grid(truth.back(), building, random));
    instance.truth.insert(x(k), truth[k]);
    instance.start.insert(x(k), k == 0 ? truth[k] : noisy(truth[k], 0.1, 0.05, random));
    if (k > 0) see(k - 1, k);
    std::array<int, Pose::space_dim> cell;
    for (int axis = 0; axis < Pose::space_dim; ++axis) cell[axis] = static_cast<int>(truth[k].p[axis]);
    std::vector<int>& earlier = visits[cell];
    if (!earlier.empty() && random.chance(0.5)) see(earlier[random.index(static_cast<int>(earlier.size()))], k);
    earlier.push_back(k);
  }
  instance.graph.fix(x(0));
  return instance;
}

}  // namespace

Instance grid_walk(int space, int poses, unsigned seed) { return space == 2 ? walk<Pose2>(poses, seed) : walk<Pose3>(poses, seed); }

}  // namespace holdfast::bench
