// Problems cut into a part for each process.
#pragma once

#include <holdfast/factors/between.hpp>
#include <holdfast/factors/prior.hpp>
#include <holdfast/factors/range_ball.hpp>
#include <holdfast/graph/starts/chordal.hpp>
#include <holdfast/solvers/distributed/distributed_graph.hpp>

#include "tests/problems.hpp"

namespace holdfast::testing {

struct Whole {
  Graph graph;
  Values values;
};

/// This process's part: its share of the sorted keys, and every factor whose first key is among them.
inline DistributedGraph part_of(const Whole& whole, const Communicator& all) {
  const std::vector<Key> keys = whole.values.keys();
  std::unordered_map<Key, int> owner;
  for (std::size_t i = 0; i < keys.size(); ++i) owner[keys[i]] = static_cast<int>(i * all.size() / keys.size());
  Graph graph;
  Values values;
  for (const auto& pool : whole.values.pools())
    for (int i = 0; i < pool->size(); ++i)
      if (owner[pool->keys()[i]] == all.rank()) {
        values.insert_ambient(pool->keys()[i], pool->kind(), std::as_const(*pool).data(i));
        if (whole.graph.is_fixed(pool->keys()[i])) graph.fix(pool->keys()[i]);
      }
  for (std::size_t b = 0; b < whole.graph.batches().size(); ++b)
    for (int i = 0; i < whole.graph.batches()[b]->size(); ++i)
      if (owner[whole.graph.batches()[b]->keys(i)[0]] == all.rank()) graph.add_from(whole.graph, whole.graph.id_of(static_cast<int>(b), i));
  return DistributedGraph(all, std::move(graph), std::move(values));
}

/// Nodes in a square, one a square metre, a tenth of them fixed anchors, range balls between those nearer than `radius`, 2 % of noise; the
/// others start at the middle.
inline Whole range_network(int nodes, unsigned seed, double radius = 1.7) {
  std::mt19937_64 rng(seed);
  const double side = std::sqrt(nodes);
  std::vector<Vector<2>> truth(nodes);
  for (Vector<2>& p : truth) p = {uniform(rng, 0, side), uniform(rng, 0, side)};
  Whole whole;
  const auto key = [](int i) { return Agent('N', static_cast<std::uint64_t>(i))(0); };
  for (int i = 0; i < nodes; ++i) {
    const bool anchor = i % 10 == 0;
    whole.values.insert(key(i), Point2(anchor ? truth[i] : Vector<2>(side / 2, side / 2)));
    if (anchor) whole.graph.fix(key(i));
  }
  for (int i = 0; i < nodes; ++i)
    for (int j = i + 1; j < nodes; ++j) {
      const double distance = (truth[i] - truth[j]).norm();
      if (distance < radius && (i % 10 != 0 || j % 10 != 0))
        whole.graph.add(RangeBall<Point2, Point2>{distance * (1 + 0.02 * uniform(rng, -1.7, 1.7)), 0.02 * radius}, {key(i), key(j)});
    }
  return whole;
}

/// Laps on a circle with odometry and closures to the lap before, held by a prior; Huber on the closures. Start: the chordal one.
inline Whole laps(int poses, unsigned seed) {
  std::mt19937_64 rng(seed);
  constexpr int kLap = 40;
  const Agent A('A');
  std::vector<Pose2> truth;
  for (int i = 0; i < poses; ++i) {
    const double angle = 2 * M_PI * i / kLap;
    truth.push_back(Pose2(10 * std::cos(angle), 10 * std::sin(angle), angle + M_PI / 2));
  }
  Whole whole;
  const auto seen = [&](int i, int j) {
    const Vector<3> noise(uniform(rng, -0.1, 0.1), uniform(rng, -0.1, 0.1), uniform(rng, -0.02, 0.02));
    return (truth[i].inverse() * truth[j]).retract(noise);
  };
  const auto between = [&](int i, int j) { return Between<Pose2>::from_sigmas(seen(i, j), Vector<3>(0.1, 0.1, 0.02)); };
  for (int i = 0; i < poses; ++i) whole.values.insert(A(i), i == 0 ? truth[0] : whole.values.at<Pose2>(A(i - 1)));
  whole.graph.add(Prior<Pose2>::from_sigmas(truth[0], Vector<3>(0.1, 0.1, 0.02)), {A(0)});
  for (int i = 1; i < poses; ++i) whole.graph.add(between(i - 1, i), {A(i - 1), A(i)});
  for (int i = kLap; i < poses; i += 3) whole.graph.add(between(i - kLap, i), {A(i - kLap), A(i)}, Huber{1.5});
  if (!chordal_start(whole.graph, whole.values)) throw Error("the laps have no chordal start");
  return whole;
}

inline Options tight() {
  Options options;
  options.cost_tolerance = 1e-13;
  options.gradient_tolerance = 1e-9;
  return options;
}

}  // namespace holdfast::testing
