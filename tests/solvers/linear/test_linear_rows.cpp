#include <gtest/gtest.h>

#include <holdfast/factors/white_jerk.hpp>
#include <holdfast/solvers/linear/internal/linear_rows.hpp>
#include <holdfast/solvers/linear/internal/normal_equations.hpp>

#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

using holdfast::detail::LinearRows;

using Measurement = HuberMeasurement<Motion2>;

struct Chain {
  Graph graph;
  Values values;

  /// One agent's states in no particular order of their keys, the third one fixed.
  Chain(const Loss& loss, std::mt19937_64& rng) {
    constexpr int n = 12;
    for (int k = 0; k < n; ++k) {
      const int key = (5 * k) % n;
      values.insert(Key('A', key), Motion2(Vector<4>::Random() * 3));
      graph.add(Prior<Motion2>::from_sigmas(Motion2(), Vector<4>::Constant(2)),
                {Key('A', key)});  // what redescending losses let go, it holds
      graph.add(Measurement::of_position(Vector<2>::Random() * 4, Vector<2>::Random(), Matrix<2, 2>::Identity(), uniform(rng, 0.5, 2)),
                {Key('A', key)}, loss);
    }
    for (int k = 0; k + 1 < n; ++k)
      graph.add(WhiteAcceleration<Motion2>::exact(0.3, 1 + k % 3, Matrix<4, 4>::Identity()), {Key('A', k), Key('A', k + 1)}, loss);
    graph.fix(Key('A', 3));
  }
};

/// values ⊕ δ, (H + λ diag H) δ = −g, by dense algebra on the blocks that the other back-ends use.
Values dense_step(const Graph& graph, const Values& values, Curvature curvature, double lambda) {
  const Resolved resolved(graph, values);
  std::vector<int> order;
  for (std::size_t v = 0; v < resolved.variables().size(); ++v)
    if (resolved.variables()[v].offset >= 0) order.push_back(static_cast<int>(v));
  NormalEquations normal(graph, resolved, order);
  normal.linearize(graph, resolved, values, curvature);
  const BlockPattern& pattern = normal.pattern();
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(pattern.scalar_size(), pattern.scalar_size());
  for (int c = 0; c < pattern.size(); ++c)
    for (int k = pattern.column_begin[c]; k < pattern.column_begin[c + 1]; ++k) {
      const int r = pattern.rows[k];
      const Eigen::Map<const Eigen::MatrixXd> block(&normal.H()[pattern.block_begin[k]], pattern.dims[r], pattern.dims[c]);
      H.block(pattern.offsets[r], pattern.offsets[c], pattern.dims[r], pattern.dims[c]) = block;
      H.block(pattern.offsets[c], pattern.offsets[r], pattern.dims[c], pattern.dims[r]) = block.transpose();
    }
  H.diagonal() *= 1 + lambda;
  const Eigen::VectorXd g = Eigen::Map<const Eigen::VectorXd>(normal.gradient().data(), pattern.scalar_size());
  const Eigen::VectorXd step = -H.ldlt().solve(g);
  std::vector<double> tangent(step.size());
  normal.to_tangent(resolved, step.data(), tangent.data());
  Values moved = values;
  resolved.retract(values, tangent.data(), moved);
  return moved;
}

Values step(LinearRows& rows, const Graph& graph, const Values& values, Curvature curvature, double lambda) {
  EXPECT_TRUE(rows.load(graph, values));
  EXPECT_NEAR(rows.linearize(graph, curvature), graph.cost(values), 1e-12 * graph.cost(values));
  EXPECT_GT(rows.solve_damped(lambda), 0);
  rows.apply_step(graph);
  EXPECT_NEAR(rows.phi(graph, 0).slope, rows.slope(), 1e-10 * std::abs(rows.slope()));
  Values moved = values;
  rows.move_along(1);
  rows.retract(moved);
  EXPECT_NEAR(rows.phi(graph, 0).value, graph.cost(moved), 1e-11 * graph.cost(moved));
  return moved;
}

TEST(LinearRows, TakesTheStepOfTheDenseNormalEquations) {
  std::mt19937_64 rng(11);
  std::srand(11);
  LinearRows rows;  // one object for all structures
  std::vector<Loss> losses = every_loss(4);
  losses.erase(std::remove_if(losses.begin(), losses.end(), [](const Loss& loss) { return loss.one_sided; }), losses.end());
  for (const Loss& loss : losses)
    for (const Curvature curvature : {Curvature::irls, Curvature::newton})
      for (const double lambda : {0.0, 0.1}) {
        const Chain chain(loss, rng);
        const double size = 1 + largest_difference(chain.values, dense_step(chain.graph, chain.values, curvature, lambda));
        EXPECT_LT(largest_difference(step(rows, chain.graph, chain.values, curvature, lambda),
                                     dense_step(chain.graph, chain.values, curvature, lambda)),
                  1e-9 * size)
            << loss.str() << " curvature " << static_cast<int>(curvature) << " λ " << lambda;
      }
}

/// Rows that one loss weighs together: 3 of a point, 6 of a motion, 9 of a motion with acceleration.
TEST(LinearRows, TakesTheStepOfTheDenseNormalEquationsInSpace) {
  std::mt19937_64 rng(16);
  std::srand(16);
  Graph graph;
  Values values;
  for (int k = 0; k < 6; ++k) {
    values.insert(Key('A', k), Accel3(Vector<9>::Random() * 3));
    values.insert(Key('B', k), Motion3(Vector<6>::Random() * 3));
    graph.add(Prior<Accel3>::from_covariance(Accel3(), random_covariance<9>(rng)), {Key('A', k)}, Cauchy{2});
    graph.add(Prior<Motion3>::from_covariance(Motion3(), random_covariance<6>(rng)), {Key('B', k)}, Huber{1});
    graph.add(HuberMeasurementEdge<Motion3, Motion3>::of_position(Vector<3>::Random() * 4, Matrix<3, 3>::Identity()),
              {Key('B', k), Key('B', (k + 1) % 6)}, TruncatedSquares{30});
    if (k > 0) graph.add(WhiteJerk<Accel3>::continuous(0.5, 1), {Key('A', k - 1), Key('A', k)}, StudentT{3});
    if (k > 0) graph.add(WhiteAcceleration<Motion3>::continuous(0.5, 1), {Key('B', k - 1), Key('B', k)}, PseudoHuber{1});
  }
  LinearRows rows;
  for (const Curvature curvature : {Curvature::irls, Curvature::newton}) {
    const Values expected = dense_step(graph, values, curvature, 0.1);
    EXPECT_LT(largest_difference(step(rows, graph, values, curvature, 0.1), expected), 1e-9 * (1 + largest_difference(values, expected)));
  }
}

TEST(LinearRows, SeesAnEntryThatIsNoLongerZero) {
  std::mt19937_64 rng(12);
  std::srand(12);
  Chain chain(Huber{1}, rng);
  const FactorId id =
      chain.graph.add(Measurement::of_position(Vector<2>(1, 2), Vector<2>(0, 0), Matrix<2, 2>::Identity()), {Key('A', 5)}, Squared{});
  LinearRows rows;
  step(rows, chain.graph, chain.values, Curvature::irls, 0);
  chain.graph.at<Measurement>(id).B << 1, 2, 3, 4, 5, 6, 7, 8;
  EXPECT_LT(largest_difference(step(rows, chain.graph, chain.values, Curvature::irls, 0),
                               dense_step(chain.graph, chain.values, Curvature::irls, 0)),
            1e-9);
}

TEST(LinearRows, SeesALossThatWeighsWholeBlocksNow) {
  std::mt19937_64 rng(15);
  std::srand(15);
  Chain chain(Squared{}, rng);
  LinearRows rows;
  step(rows, chain.graph, chain.values, Curvature::newton, 0);
  for (const Loss& loss : {Loss(Cauchy{1}), per_component(Huber{1}), Loss(Huber{0.5}), Loss(Squared{})}) {
    for (int b = 0; b < static_cast<int>(chain.graph.batches().size()); ++b) chain.graph.set_loss(b, loss);
    const Values expected = dense_step(chain.graph, chain.values, Curvature::newton, 0.1);
    EXPECT_LT(largest_difference(step(rows, chain.graph, chain.values, Curvature::newton, 0.1), expected),
              1e-9 * (1 + largest_difference(chain.values, expected)))
        << loss.str();
  }
}

TEST(LinearRows, LeavesWideProblemsToOthers) {
  std::mt19937_64 rng(13);
  Graph graph;
  Values values;
  constexpr int n = 300;
  for (int i = 0; i < n; ++i) {
    values.insert(Key('L', i), Point2(0, 0));
    graph.add(Prior<Point2>::from_sigmas(Point2(1, 1), Vector<2>(1, 1)), {Key('L', i)});
  }
  std::uniform_int_distribution<int> any(0, n - 1);
  for (int k = 0; k < 4 * n; ++k)
    if (const int a = any(rng), b = any(rng); a != b) graph.add(PositionStep<Point2, Point2>{1}, {Key('L', a), Key('L', b)});
  LinearRows rows;
  EXPECT_FALSE(rows.load(graph, values));
  EXPECT_FALSE(rows.load(graph, values));
  Values moved = values;
  EXPECT_NEAR(solve("irls", graph, moved).cost, 0, 1e-20);
}

TEST(LinearRows, ATwistedWindowNeedsNoMemoryOfItsLastLayout) {
  std::mt19937_64 rng(14);
  std::srand(14);
  LinearRows rows;
  Chain large(Huber{1}, rng);
  step(rows, large.graph, large.values, Curvature::newton, 0);
  Graph small;
  Values values;
  values.insert(Key('B', 0), Motion2(Vector<4>(1, 2, 3, 4)));
  small.add(Prior<Motion2>::from_sigmas(Motion2(Vector<4>::Zero()), Vector<4>::Ones()), {Key('B', 0)});
  const Values moved = step(rows, small, values, Curvature::newton, 0);
  EXPECT_NEAR(moved.at<Motion2>(Key('B', 0)).value.norm(), 0, 1e-12);
}

}  // namespace
}  // namespace holdfast::testing
