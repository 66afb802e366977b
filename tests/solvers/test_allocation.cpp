// A solve of a structure that the solver has met before allocates nothing.
#include <gtest/gtest.h>

#include <holdfast/solvers/irls/irls.hpp>

#include "tests/counting_new.hpp"
#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

constexpr Agent A('A');

struct Counted {
  Summary summary;
  long allocations = 0;
};
Counted solve_counted(Backend& backend, const Graph& graph, Values& values) {
  allocations = 0;
  counting = true;
  Counted result{backend.solve(graph, values)};
  counting = false;
  result.allocations = allocations;
  return result;
}

/// 15 states of paper A's window, each measured; the odd ones are outliers of the given size [m].
struct Window {
  Graph graph;
  Values start;
  std::vector<FactorId> measurements;

  Window() {
    const auto motion = WhiteAcceleration<Motion2>::exact(0.5, 1, Matrix<4, 4>::Identity());
    for (int k = 0; k < 15; ++k) {
      start.insert(A(k), Motion2());
      measurements.push_back(
          graph.add(HuberMeasurement<Motion2>::of_position(Vector<2>(0, 0), Vector<2>(0, 0), Matrix<2, 2>::Identity()), {A(k)}));
      if (k > 0) graph.add(motion, {A(k - 1), A(k)});
    }
  }
  void measure(std::uint64_t seed, double outlier) {
    std::mt19937_64 rng(seed);
    for (int k = 0; k < 15; ++k) {
      const Vector<2> z = -Vector<2>(3.0 * k, 0.2 * k * k) + random_vector<2>(rng) + (k % 2 ? outlier : 0) * random_unit<2>(rng);
      graph.at<HuberMeasurement<Motion2>>(measurements[k]) =
          HuberMeasurement<Motion2>::of_position(z, Vector<2>(0, 0), Matrix<2, 2>::Identity());
      start.at<Motion2>(A(k)) = Motion2(-z[0], 0.0, -z[1], 0.0);
    }
  }
};

TEST(Allocation, IsCounted) {
  allocations = 0;
  counting = true;
  const auto backend = make_backend("irls");
  counting = false;
  EXPECT_GT(allocations, 0);
}

TEST(Allocation, NoneInAWindowMetBefore) {
  for (const Reweighting reweighting : {Reweighting::automatic, Reweighting::irls}) {
    Options options;
    options.cost_tolerance = 1e-8;
    Irls backend(options, {reweighting});
    Window window;
    window.measure(1, 50);
    Values x = window.start;
    EXPECT_GT(solve_counted(backend, window.graph, x).allocations, 0);
    for (std::uint64_t seed = 2; seed < 20; ++seed) {
      window.measure(seed, 10.0 * static_cast<double>(seed));
      x.assign(window.start);
      const Counted again = solve_counted(backend, window.graph, x);
      EXPECT_EQ(again.allocations, 0) << again.summary.str();
      EXPECT_EQ(again.summary.termination, Termination::converged);
      EXPECT_GT(again.summary.iterations, 1);
    }
  }
}

template <class V>
void expect_none_in_a_pose_graph(const Loss& loss) {
  SmallProblem problem = slam<V>(1, 30, 0.1, loss);
  const auto backend = make_backend("irls");
  Values x = problem.start;
  backend->solve(problem.graph, x);
  std::mt19937_64 rng(2);
  for (const double sigma : {0.05, 0.3, 1.0}) {  // near the answer, and so far from it that steps bend and are rejected
    for (const auto& batch : problem.graph.batches())
      for (int i = 0; i < batch->size(); ++i) {
        const FactorId id = problem.graph.id_of(static_cast<int>(&batch - problem.graph.batches().data()), i);
        if (batch->factor_type() != typeid(Between<V>)) continue;
        V& measured = problem.graph.at<Between<V>>(id).measured;
        measured = measured.retract(random_vector<V::dim>(rng, 0.02));
      }
    x.assign(perturbed(problem.graph, problem.truth, sigma, rng));
    const Counted again = solve_counted(*backend, problem.graph, x);
    EXPECT_EQ(again.allocations, 0) << again.summary.str();
    EXPECT_TRUE(again.summary.usable());
    EXPECT_GT(again.summary.iterations, 1);
  }
}

TEST(Allocation, NoneInAPoseGraphMetBefore) {
  for (const Loss& loss : {Loss(Squared{}), Loss(Huber{2}), Loss(Cauchy{2})}) {
    expect_none_in_a_pose_graph<Pose2>(loss);
    expect_none_in_a_pose_graph<Pose3>(loss);
  }
}

}  // namespace
}  // namespace holdfast::testing
