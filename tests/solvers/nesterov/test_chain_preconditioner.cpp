// P⁻¹ g against dense linear algebra: H within each agent's chain, without what ties agents to each other.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <holdfast/solvers/nesterov/internal/chain_preconditioner.hpp>

#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Agent A('A'), B('B');

/// Two agents of three points each, steps along each and one step between them.
struct TwoChains {
  Graph graph;
  Values values;

  explicit TwoChains(bool with_tie, bool with_shortcut = false) {
    for (const Agent& agent : {A, B})
      for (int i = 0; i < 3; ++i) {
        values.insert(agent(i), Point2(i, i * i));
        graph.add(Prior<Point2>::from_sigmas(Point2(0, 0), Vector<2>(2, 3)), {agent(i)}, Huber{1}, 1 + i);
        if (i > 0) graph.add(PositionStep<Point2, Point2>{0.5}, {agent(i - 1), agent(i)});
      }
    if (with_tie) graph.add(PositionStep<Point2, Point2>{0.7}, {A(1), B(2)});
    if (with_shortcut) graph.add(PositionStep<Point2, Point2>{0.7}, {A(0), A(2)});
  }
};

/// Σ w ρ'(0) JᵀJ in Resolved's tangent, of the factors that `keep` picks; the others give their diagonal blocks alone.
template <class Keep>
MatrixXd hessian(const Graph& graph, const Values& values, const Resolved& resolved, const Keep& keep) {
  MatrixXd H = MatrixXd::Zero(resolved.tangent_dim(), resolved.tangent_dim());
  for (std::size_t b = 0; b < graph.batches().size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    for (int i = 0; i < batch.size(); ++i) {
      VectorXd r(batch.residual_dim());
      MatrixXd J(batch.residual_dim(), batch.total_dim());
      batch.evaluate(values, resolved.batches()[b].index.data(), i, i + 1, r.data(), J.data());
      const bool kept = keep(batch, i);
      for (int k = 0; k < batch.arity(); ++k)
        for (int l = 0; l < batch.arity(); ++l) {
          if (k != l && !kept) continue;
          const auto& vk = resolved.variables()[resolved.batches()[b].variable[i * batch.arity() + k]];
          const auto& vl = resolved.variables()[resolved.batches()[b].variable[i * batch.arity() + l]];
          H.block(vk.offset, vl.offset, 2, 2) += batch.weight(i) * J.middleCols(2 * k, 2).transpose() * J.middleCols(2 * l, 2);
        }
    }
  }
  return H;
}

void expect_is_inverse_of(const TwoChains& problem, const MatrixXd& P, const Resolved& resolved) {
  ChainPreconditioner preconditioner(problem.graph, resolved);
  preconditioner.update(problem.graph, resolved, problem.values, nullptr);
  std::mt19937_64 rng(1);
  const Vector<12> g = random_vector<12>(rng);
  std::vector<double> out;
  const double norm2 = preconditioner.apply(resolved, {g.data(), g.data() + 12}, out);
  const VectorXd expected = P.ldlt().solve(VectorXd(g));
  EXPECT_LT((Eigen::Map<VectorXd>(out.data(), 12) - expected).norm(), 1e-6 * expected.norm());  // but for a roundness of 1e-9
  EXPECT_NEAR(norm2, g.dot(expected), 1e-6 * norm2);
}

TEST(ChainPreconditioner, IsAllOfHWhereEveryAgentIsAChainOfItsOwn) {
  const TwoChains problem(false);
  const Resolved resolved(problem.graph, problem.values);
  expect_is_inverse_of(problem, hessian(problem.graph, problem.values, resolved, [](const auto&, int) { return true; }), resolved);
}

TEST(ChainPreconditioner, KeepsOfOtherFactorsTheirDiagonalBlocks) {
  const TwoChains problem(true, true);
  const Resolved resolved(problem.graph, problem.values);
  const auto along_a_chain = [](const FactorBatch& batch, int i) {
    if (batch.arity() == 1) return true;
    const Key a = batch.keys(i)[0], b = batch.keys(i)[1];
    for (const Agent& agent : {A, B})
      for (int k = 1; k < 3; ++k)
        if (a == agent(k - 1) && b == agent(k)) return true;
    return false;
  };
  expect_is_inverse_of(problem, hessian(problem.graph, problem.values, resolved, along_a_chain), resolved);
}

// Each rounding adds ten times as much of the identity, until that is as large as P's own stiffest trace.
TEST(ChainPreconditioner, RoundsOffUntilItIsRound) {
  const TwoChains problem(false);
  const Resolved resolved(problem.graph, problem.values);
  ChainPreconditioner preconditioner(problem.graph, resolved);
  preconditioner.update(problem.graph, resolved, problem.values, nullptr);
  std::vector<double> g(12, 0.0), out;
  g[0] = 1;
  double before = preconditioner.apply(resolved, g, out);
  int rounds = 0;
  for (; preconditioner.round_off(); ++rounds) {
    const double now = preconditioner.apply(resolved, g, out);
    EXPECT_LT(now, before);  // stiffer
    before = now;
  }
  EXPECT_EQ(rounds, 5);  // 1e-4, 1e-3, …, 1
  EXPECT_FALSE(preconditioner.round_off());
}

}  // namespace
}  // namespace holdfast::testing
