#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <holdfast/solvers/linear/internal/normal_equations.hpp>

#include "tests/problems.hpp"

namespace holdfast {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::default_loss;
using testing::kLossKinds;

constexpr Agent A('A'), L('L');

struct Dense {
  MatrixXd H;
  VectorXd g;
  double cost = 0;
};

/// JᵀWJ, JᵀWr and the cost, one factor after the other, in Resolved's tangent.
Dense assembled(const Graph& graph, const Resolved& resolved, const Values& values) {
  const int n = resolved.tangent_dim();
  Dense dense{MatrixXd::Zero(n, n), VectorXd::Zero(n)};
  for (std::size_t b = 0; b < graph.batches().size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    VectorXd r(batch.residual_dim());
    MatrixXd J(batch.residual_dim(), batch.total_dim());
    for (int i = 0; i < batch.size(); ++i) {
      batch.evaluate(values, resolved.batches()[b].index.data(), i, i + 1, r.data(), J.data());
      const testing::ReferenceTerm term = testing::reference_term(batch.loss(i), batch.weight(i), r);
      MatrixXd in_place = MatrixXd::Zero(r.size(), n);
      int column = 0;
      for (int k = 0; k < batch.arity(); column += batch.dims()[k++]) {
        const int offset = resolved.variables()[resolved.batches()[b].variable[static_cast<std::size_t>(i) * batch.arity() + k]].offset;
        if (offset >= 0) in_place.middleCols(offset, batch.dims()[k]) = J.middleCols(column, batch.dims()[k]);
      }
      dense.H += in_place.transpose() * term.weights.asDiagonal() * in_place;
      dense.g += in_place.transpose() * term.weights.cwiseProduct(r);
      dense.cost += term.cost;
    }
  }
  return dense;
}

std::vector<int> free_variables(const Resolved& resolved) {
  std::vector<int> free;
  for (std::size_t v = 0; v < resolved.variables().size(); ++v)
    if (resolved.variables()[v].offset >= 0) free.push_back(static_cast<int>(v));
  return free;
}

/// H and g as full matrices in Resolved's tangent.
Dense expanded(const NormalEquations& normal, const Resolved& resolved, double cost) {
  const BlockPattern& pattern = normal.pattern();
  const int n = pattern.scalar_size();
  Dense dense{MatrixXd::Zero(n, n), VectorXd::Zero(n), cost};
  const auto offset = [&](int block) { return resolved.variables()[normal.order()[block]].offset; };
  for (int column = 0; column < pattern.size(); ++column)
    for (int k = pattern.column_begin[column]; k < pattern.column_begin[column + 1]; ++k) {
      const int row = pattern.rows[k];
      const Eigen::Map<const MatrixXd> block(&normal.H()[pattern.block_begin[k]], pattern.dims[row], pattern.dims[column]);
      dense.H.block(offset(row), offset(column), pattern.dims[row], pattern.dims[column]) = block;
      dense.H.block(offset(column), offset(row), pattern.dims[column], pattern.dims[row]) = block.transpose();
    }
  normal.to_tangent(resolved, normal.gradient().data(), dense.g.data());
  return dense;
}

void expect_assembled(const Graph& graph, const Values& values, std::uint64_t seed) {
  const Resolved resolved(graph, values);
  std::vector<int> order = free_variables(resolved);
  std::mt19937_64 rng(seed);
  std::shuffle(order.begin(), order.end(), rng);
  NormalEquations normal(graph, resolved, order);
  const double cost = normal.linearize(graph, resolved, values, Curvature::irls);
  const Dense actual = expanded(normal, resolved, cost), expected = assembled(graph, resolved, values);
  EXPECT_LT((actual.H - expected.H).norm(), 1e-13 * (1 + expected.H.norm()));
  EXPECT_LT((actual.g - expected.g).norm(), 1e-13 * (1 + expected.H.norm()));
  EXPECT_NEAR(actual.cost, expected.cost, 1e-12 * expected.cost);
}

TEST(NormalEquations, AreThoseOfEveryLossInAnyOrder) {
  for (int kind = 0; kind < kLossKinds; ++kind)
    for (const Loss& loss : {default_loss(kind), per_component(default_loss(kind))}) {
      SCOPED_TRACE(loss.str());
      const auto plane = testing::slam<Pose2>(1, 9, 0.3, loss, 0.3);
      const auto space = testing::slam<Pose3>(2, 7, 0.3, loss, 0.3);
      for (const std::uint64_t seed : {1, 2}) {
        expect_assembled(plane.graph, plane.start, seed);
        expect_assembled(space.graph, space.start, seed);
      }
    }
}

TEST(NormalEquations, LeaveFixedVariablesOut) {
  auto problem = testing::slam<Pose2>(3, 8, 0.3, Huber{1}, 0.3);
  for (const Key key : {A(0), A(4), L(1)}) problem.graph.fix(key);
  expect_assembled(problem.graph, problem.start, 5);
}

TEST(NormalEquations, TakeFactorsWithoutAndWithWeight) {
  Graph graph;
  Values values;
  for (int i = 0; i < 3; ++i) values.insert(A(i), Point2(i, i * i));
  graph.add(Range<Point2, Point2>{3, 0.5}, {A(2), A(0)}, Huber{1}, 0.25);
  graph.add(Range<Point2, Point2>{3, 0.5}, {A(0), A(1)}, Huber{1}, 0);
  graph.add(Range<Point2, Point2>{3, 0.5}, {A(1), A(2)}, Squared{}, 3);
  expect_assembled(graph, values, 1);
  expect_assembled(graph, values, 2);
}

TEST(NormalEquations, KnownResidualsAndJacobiansGiveTheSame) {
  for (const Curvature curvature : {Curvature::irls, Curvature::newton}) {
    auto problem = testing::slam<Pose3>(9, 8, 0.3, Cauchy{1}, 0.3);
    problem.graph.fix(A(2));
    const Resolved resolved(problem.graph, problem.start);
    std::vector<std::vector<double>> r, J;
    for (std::size_t b = 0; b < problem.graph.batches().size(); ++b) {
      const FactorBatch& batch = *problem.graph.batches()[b];
      const std::size_t rows = static_cast<std::size_t>(batch.size()) * batch.residual_dim();
      r.emplace_back(rows);
      J.emplace_back(rows * batch.total_dim());
      batch.evaluate(problem.start, resolved.batches()[b].index.data(), 0, batch.size(), r.back().data(), J.back().data());
    }
    NormalEquations normal(problem.graph, resolved, free_variables(resolved));
    const double cost = normal.linearize(problem.graph, resolved, problem.start, curvature);
    const Dense direct = expanded(normal, resolved, cost);
    for (const int threads : {1, 3}) {
      ThreadPool pool(threads);
      EXPECT_NEAR(normal.linearize_at(problem.graph, r, J, curvature, &pool), cost, 1e-13 * cost);
      const Dense known = expanded(normal, resolved, cost);
      EXPECT_LT((known.H - direct.H).norm(), 1e-13 * direct.H.norm());
      EXPECT_LT((known.g - direct.g).norm(), 1e-13 * direct.H.norm());
    }
  }
}

TEST(NormalEquations, TakeABatchThatHasBeenEmptied) {
  auto problem = testing::slam<Pose2>(4, 5, 0.3);
  const FactorId id = problem.graph.add(Prior<Point2>::from_sigmas(Point2(0, 0), Vector<2>(1, 1)), {L(0)});
  problem.graph.remove(id);
  expect_assembled(problem.graph, problem.start, 1);
  ThreadPool pool(2);
  const Resolved resolved(problem.graph, problem.start);
  NormalEquations normal(problem.graph, resolved, free_variables(resolved));
  EXPECT_NEAR(normal.linearize(problem.graph, resolved, problem.start, Curvature::irls, &pool), problem.graph.cost(problem.start), 1e-10);
}

TEST(NormalEquations, HaveTheSameBitsForAnyNumberOfThreads) {
  for (const Curvature curvature : {Curvature::irls, Curvature::newton}) {
    const auto problem = testing::slam<Pose2>(5, 700, 0.3, Cauchy{1}, 0.3);
    const Resolved resolved(problem.graph, problem.start);
    NormalEquations normal(problem.graph, resolved, free_variables(resolved));
    const double cost = normal.linearize(problem.graph, resolved, problem.start, curvature);
    const std::vector<double> H = normal.H(), g = normal.gradient();
    for (const int threads : {1, 2, 3, 5}) {
      ThreadPool pool(threads);
      for (int round = 0; round < 5; ++round) {
        EXPECT_EQ(normal.linearize(problem.graph, resolved, problem.start, curvature, &pool), cost) << threads;
        EXPECT_EQ(normal.H(), H) << threads;
        EXPECT_EQ(normal.gradient(), g) << threads;
      }
    }
  }
}

TEST(NormalEquations, MoreThreadsThanVariablesAreNoTrouble) {
  const auto problem = testing::range_balls<Point2>(6, 2, Huber{1});
  const Resolved resolved(problem.graph, problem.start);
  NormalEquations normal(problem.graph, resolved, free_variables(resolved));
  normal.linearize(problem.graph, resolved, problem.start, Curvature::irls);
  const std::vector<double> H = normal.H();
  ThreadPool pool(8);
  normal.linearize(problem.graph, resolved, problem.start, Curvature::irls, &pool);
  EXPECT_EQ(normal.H(), H);
}

TEST(NormalEquations, PatternIsALowerTriangleByColumns) {
  const auto problem = testing::slam<Pose2>(7, 10, 0.1);
  const Resolved resolved(problem.graph, problem.start);
  NormalEquations normal(problem.graph, resolved, free_variables(resolved));
  const BlockPattern& pattern = normal.pattern();
  EXPECT_EQ(pattern.scalar_size(), resolved.tangent_dim());
  for (int column = 0; column < pattern.size(); ++column) {
    EXPECT_EQ(pattern.rows[pattern.column_begin[column]], column);  // the diagonal block first
    for (int k = pattern.column_begin[column] + 1; k < pattern.column_begin[column + 1]; ++k)
      EXPECT_GT(pattern.rows[k], pattern.rows[k - 1]);
  }
}

/// d gradient / d tangent by central differences: only where residuals are linear is it what Curvature::newton promises.
MatrixXd numeric_hessian(const Graph& graph, const Resolved& resolved, const Values& values) {
  const int n = resolved.tangent_dim();
  constexpr double h = 1e-5;
  MatrixXd H(n, n);
  GradientEvaluator evaluate(graph);
  std::vector<double> delta(n, 0.0), ahead, behind;
  Values moved = values;
  for (int i = 0; i < n; ++i) {
    delta[i] = h;
    resolved.retract(values, delta.data(), moved);
    evaluate(graph, resolved, moved, ahead);
    delta[i] = -h;
    resolved.retract(values, delta.data(), moved);
    evaluate(graph, resolved, moved, behind);
    delta[i] = 0;
    for (int j = 0; j < n; ++j) H(j, i) = (ahead[j] - behind[j]) / (2 * h);
  }
  return H;
}

/// One linear factor of four components under a loss.
Dense newton_of_one_factor(const Loss& loss, const Motion2& at, MatrixXd& numeric) {
  Graph graph;
  Values values;
  values.insert(A(0), at);
  Matrix<4, 4> information = Matrix<4, 4>::Ones() * 0.2;
  information.diagonal() << 1, 2, 3, 4;
  graph.add(Prior<Motion2>::from_information(Motion2(0, 0, 0, 0), information), {A(0)}, loss, 0.8);
  const Resolved resolved(graph, values);
  NormalEquations normal(graph, resolved, free_variables(resolved));
  const double cost = normal.linearize(graph, resolved, values, Curvature::newton);
  numeric = numeric_hessian(graph, resolved, values);
  return expanded(normal, resolved, cost);
}

bool has_kink(const Loss& loss) { return loss.kind == Loss::Kind::TruncatedSquares; }

TEST(NormalEquations, NewtonIsTheSecondDerivativeWhereThatIsPositive) {
  int positive = 0;
  for (int kind = 0; kind < kLossKinds; ++kind)
    for (Loss loss : {default_loss(kind), per_component(default_loss(kind))})
      for (const double size : {0.2, 0.7, 1.5, 4.0}) {
        SCOPED_TRACE(loss.str() + " at " + std::to_string(size));
        if (has_kink(loss)) continue;
        if (loss.kind == Loss::Kind::Absolute) loss.scale = 0.5;  // wide against the step of the differences
        MatrixXd numeric;
        const Dense newton = newton_of_one_factor(loss, Motion2(size, -0.5 * size, 0.3 * size, 0.9 * size), numeric);
        EXPECT_GT(newton.H.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), -1e-12);
        if (numeric.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff() < 1e-3 * numeric.norm()) continue;
        ++positive;
        EXPECT_LT((newton.H - numeric).norm(), 1e-6 * (1 + numeric.norm()));
      }
  EXPECT_GT(positive, 25);
}

/// Distance to a disc round another point, and what Gauss–Newton does not see of it: how the direction turns.
struct DiscOfMine {
  double radius;  // [m]
  double sigma;   // [m]
  using Variables = variables<Point2, Point2>;
  static constexpr int residual_dim = 1;
  static constexpr bool is_convex = true;
  Vector<1> operator()(const Point2& a, const Point2& b, Jacobians<DiscOfMine>* J = nullptr) const {
    const Vector<2> d = a.value - b.value;
    const double n = d.norm();
    if (J != nullptr) {
      J->all.setZero();
      if (n > radius) J->all << d.transpose() / (n * sigma), -d.transpose() / (n * sigma);
    }
    return Vector<1>(std::max(0.0, n - radius) / sigma);
  }
  Matrix<4, 4> hessian(const Point2& a, const Point2& b) const {
    const Vector<2> d = a.value - b.value;
    const double n = d.norm();
    if (n <= radius) return Matrix<4, 4>::Zero();
    const Matrix<2, 2> along = d * d.transpose() / (n * n);
    const Matrix<2, 2> H = ((1 - radius / n) * Matrix<2, 2>::Identity() + radius / n * along) / (sigma * sigma);
    Matrix<4, 4> all;
    all << H, -H, -H, H;
    return all;
  }
};

struct Disc {
  Graph graph;
  Values values;
  Disc(const Loss& loss, double distance) {
    values.insert(A(0), Point2(0.6 * distance, 0.8 * distance));
    values.insert(A(1), Point2(0, 0));
    graph.add(DiscOfMine{2, 0.5}, {A(0), A(1)}, loss, 0.7);
    graph.add(DiscOfMine{1, 0.5}, {A(1), A(0)}, loss, 0.3);
  }
  Dense linearized(Curvature curvature) const {
    const Resolved resolved(graph, values);
    NormalEquations normal(graph, resolved, free_variables(resolved));
    const double cost = normal.linearize(graph, resolved, values, curvature);
    return expanded(normal, resolved, cost);
  }
};

MatrixXd whole(const Dense& dense) { return dense.H.selfadjointView<Eigen::Lower>(); }

TEST(NormalEquations, ExactIsTheSecondDerivativeWhereAFactorSaysItsHessian) {
  for (const Loss& loss : {Loss(Squared{}), Loss(PseudoHuber{2}), Loss(Huber{2}), per_component(PseudoHuber{1}), one_sided(Cauchy{1})})
    for (const double distance : {1.5, 2.5, 7.0}) {  // inside one disc; where Huber is squared; beyond its threshold
      SCOPED_TRACE(loss.str() + " at " + std::to_string(distance));
      const Disc disc(loss, distance);
      const Resolved resolved(disc.graph, disc.values);
      const MatrixXd numeric = numeric_hessian(disc.graph, resolved, disc.values);
      const Dense exact = disc.linearized(Curvature::exact), newton = disc.linearized(Curvature::newton);
      EXPECT_LT((whole(exact) - numeric).norm(), 2e-5 * (1e-3 + numeric.norm()));  // less a part of kLeastCurvature on a flat loss
      EXPECT_GT((whole(newton) - numeric).norm(), 0.03 * numeric.norm());
      EXPECT_EQ(exact.cost, newton.cost);
      EXPECT_EQ(exact.g, newton.g);
      EXPECT_GT(whole(exact).eigenvalues().real().minCoeff(), -1e-9);
    }
}

// On the flank of a redescending loss the true curvature is negative along the residual: cut off, the matrix stays positive semidefinite.
TEST(NormalEquations, ExactIsCutOffWhereALossBendsDown) {
  for (const Loss& loss : {Loss(Cauchy{1}), Loss(Welsch{6}), Loss(GemanMcClure{1})}) {
    const Disc disc(loss, 6);
    const Resolved resolved(disc.graph, disc.values);
    EXPECT_LT(numeric_hessian(disc.graph, resolved, disc.values).selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), -1e-3);
    EXPECT_GT(whole(disc.linearized(Curvature::exact)).selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), -1e-9) << loss.str();
  }
}

TEST(NormalEquations, ExactIsNewtonForFactorsWithoutAHessian) {
  Graph graph;
  Values values;
  values.insert(A(0), Pose2(1, 2, 0.3));
  values.insert(A(1), Pose2(2, 5, -1));
  graph.add(Prior<Pose2>::from_sigmas(Pose2(1, 1, 0.5), {1, 2, 0.5}), {A(0)}, Cauchy{1});
  graph.add(Between<Pose2>::from_sigmas(Pose2(1, 0, 0), {0.5, 1, 0.2}), {A(0), A(1)}, per_component(Welsch{2}));
  const Resolved resolved(graph, values);
  NormalEquations normal(graph, resolved, free_variables(resolved));
  normal.linearize(graph, resolved, values, Curvature::newton);
  const std::vector<double> newton = normal.H();
  normal.linearize(graph, resolved, values, Curvature::exact);
  EXPECT_EQ(normal.H(), newton);
}

TEST(NormalEquations, NewtonNeverExceedsIrls) {
  for (int kind = 0; kind < kLossKinds; ++kind) {
    const auto problem = testing::slam<Pose2>(8, 8, 0.5, default_loss(kind), 0.5);
    const Resolved resolved(problem.graph, problem.start);
    NormalEquations normal(problem.graph, resolved, free_variables(resolved));
    const double cost = normal.linearize(problem.graph, resolved, problem.start, Curvature::irls);
    const Dense irls = expanded(normal, resolved, cost);
    EXPECT_EQ(normal.linearize(problem.graph, resolved, problem.start, Curvature::newton), cost);
    const Dense newton = expanded(normal, resolved, cost);
    EXPECT_EQ(newton.g, irls.g) << default_loss(kind).str();
    EXPECT_GT(MatrixXd(irls.H - newton.H).selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), -1e-9 * irls.H.norm());
  }
}

}  // namespace
}  // namespace holdfast
