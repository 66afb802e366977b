#include <gtest/gtest.h>

#include <holdfast/graph/gradient.hpp>
#include <holdfast/graph/linear_prior.hpp>
#include <holdfast/solvers/linear/internal/normal_equations.hpp>
#include <holdfast/testing.hpp>

namespace holdfast {
namespace {

using testing::random_vector;

constexpr Agent A('A'), L('L'), S('S');

/// On a pose in the plane, one in space, a motion state and a scalar, linearised away from where they are.
struct Mixed {
  Graph graph;
  Values values;
  FactorId id;
  std::mt19937_64 rng{7};

  Mixed() {
    LinearPrior prior;
    enter(prior, A(0), testing::random_variable<Pose2>(rng));
    enter(prior, A(1), testing::random_variable<Pose3>(rng));
    enter(prior, L(0), testing::random_variable<Motion2>(rng));
    enter(prior, S(0), testing::random_variable<Scalar>(rng));
    prior.rows = 5;
    for (int k = 0; k < 5 * 14; ++k) prior.A.push_back(random_vector<1>(rng)[0]);
    for (int k = 0; k < 5; ++k) prior.b.push_back(random_vector<1>(rng)[0]);
    id = graph.add(prior);
  }
  template <class V>
  void enter(LinearPrior& prior, Key key, const V& at) {
    prior.add_variable(key, at);
    values.insert(key, at.retract(random_vector<V::dim>(rng, 0.3)));
  }
};

TEST(LinearPrior, IsTheQuadraticItSays) {
  const Mixed m;
  const LinearPrior& prior = m.graph.at<LinearPrior>(m.id);
  EXPECT_EQ(prior.columns(), 14);
  Vector<14> delta;
  const auto at = [&](int k) {
    const double* x = prior.x0.data();
    for (int j = 0; j < k; ++j) x += prior.types[j]->ambient();
    return x;
  };
  Pose2 x0;
  std::memcpy(static_cast<void*>(&x0), at(0), sizeof x0);
  delta.segment<3>(0) = x0.local(m.values.at<Pose2>(A(0)));
  Pose3 x1;
  std::memcpy(static_cast<void*>(&x1), at(1), sizeof x1);
  delta.segment<6>(3) = x1.local(m.values.at<Pose3>(A(1)));
  Motion2 x2;
  std::memcpy(static_cast<void*>(&x2), at(2), sizeof x2);
  delta.segment<4>(9) = x2.local(m.values.at<Motion2>(L(0)));
  delta[13] = m.values.at<Scalar>(S(0)).value - *at(3);
  const Eigen::VectorXd r =
      Eigen::Map<const Eigen::MatrixXd>(prior.A.data(), 5, 14) * delta + Eigen::Map<const Eigen::VectorXd>(prior.b.data(), 5);
  EXPECT_NEAR(m.graph.cost(m.values), 0.5 * r.squaredNorm(), 1e-12);
}

TEST(LinearPrior, GradientIsThatOfTheCost) {
  Mixed m;
  m.graph.set_weight(m.id, 2.5);
  const Gradient g = gradient(m.graph, m.values);
  const Resolved resolved(m.graph, m.values);
  Values moved = m.values;
  for (int c = 0; c < 14; ++c) {
    const auto slope = [&](double h) {
      std::vector<double> delta(14, 0.0);
      delta[c] = h;
      resolved.retract(m.values, delta.data(), moved);
      const double ahead = m.graph.cost(moved);
      delta[c] = -h;
      resolved.retract(m.values, delta.data(), moved);
      return (ahead - m.graph.cost(moved)) / (2 * h);
    };
    EXPECT_NEAR(g.value[c], (4 * slope(5e-4) - slope(1e-3)) / 3, 1e-7) << c;
  }
}

TEST(LinearPrior, NormalEquationsAreThoseOfItsJacobian) {
  Mixed m;
  m.graph.set_weight(m.id, 2.5);
  const Resolved resolved(m.graph, m.values);
  const FactorBatch& batch = *m.graph.batches()[0];
  Eigen::VectorXd r(5);
  Eigen::MatrixXd J(5, 14);
  batch.evaluate(m.values, resolved.batches()[0].index.data(), 0, 1, r.data(), J.data());
  std::vector<double> out(batch.stride());
  batch.contributions(m.values, resolved.batches()[0].index.data(), 0, 1, Curvature::irls, out.data());
  const Eigen::MatrixXd H = 2.5 * J.transpose() * J;
  const double* block = out.data();
  for (int b = 0, column = 0; b < 4; column += batch.dims()[b++])
    for (int a = b, row = column; a < 4; row += batch.dims()[a++]) {
      EXPECT_TRUE(Eigen::Map<const Eigen::MatrixXd>(block, batch.dims()[a], batch.dims()[b])
                      .isApprox(H.block(row, column, batch.dims()[a], batch.dims()[b]), 1e-12));
      block += batch.dims()[a] * batch.dims()[b];
    }
  EXPECT_TRUE(Eigen::Map<const Eigen::VectorXd>(block, 14).isApprox(2.5 * J.transpose() * r, 1e-12));
  EXPECT_NEAR(out.back(), 1.25 * r.squaredNorm(), 1e-12);
}

TEST(LinearPrior, IsLinearWhereItsVariablesAre) {
  const Mixed m;
  EXPECT_FALSE(m.graph.batches()[0]->is_linear());
  Graph graph;
  LinearPrior prior;
  prior.add_variable(L(0), Point2(1, 2));
  prior.rows = 1;
  prior.A = {2, 0};
  prior.b = {3};
  graph.add(prior);
  EXPECT_TRUE(graph.batches()[0]->is_linear());
  Values values;
  values.insert(L(0), Point2(1.5, 7));
  EXPECT_NEAR(graph.cost(values), 0.5 * 16, 1e-15);
}

TEST(LinearPrior, IsCheckedWhenItIsAdded) {
  Graph graph;
  LinearPrior prior;
  EXPECT_THROW(graph.add(prior), BadNumber);
  prior.add_variable(L(0), Point2(1, 2));
  prior.rows = 1;
  prior.A = {2};
  prior.b = {3};
  EXPECT_THROW(graph.add(prior), BadNumber);
  prior.A = {2, NAN};
  EXPECT_THROW(graph.add(prior), BadNumber);
  prior.A = {2, 1};
  prior.add_variable(L(0), Point2(1, 2));
  prior.A = {2, 1, 0, 0};
  EXPECT_THROW(graph.add(prior), BadKey);
  prior.keys[1] = L(1);
  const FactorId id = graph.add(prior);
  EXPECT_THROW(graph.set_loss(graph.place(id).batch, Huber{2}), BadOption);
  graph.remove(id);
  EXPECT_EQ(graph.size(), 0u);
  graph.add(prior);
  EXPECT_EQ(graph.batches().size(), 1u);  // in the memory of the first
  EXPECT_EQ(graph.batches()[0]->describe(0), "LinearPrior(L0, L1)");
}

TEST(LinearPrior, Pose3StatesTheJacobianThatDualNumbersFind) {
  std::mt19937_64 rng(3);
  const Pose3 a = Pose3().retract(random_vector<6>(rng, 0.5)), b = Pose3().retract(random_vector<6>(rng, 0.5));
  using D = Dual<6>;
  VectorT<D, 6> delta;
  for (int k = 0; k < 6; ++k) delta[k] = D(0, Vector<6>::Unit(k));
  const VectorT<D, 6> local = a.cast<D>().local(b.cast<D>().retract(delta));
  const Matrix<6, 6> J = a.local_jacobian(b);
  for (int k = 0; k < 6; ++k) EXPECT_LT((local[k].v.transpose() - J.row(k)).norm(), 1e-12) << k;
}

}  // namespace
}  // namespace holdfast
