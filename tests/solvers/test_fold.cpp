// Losses folded into the residual: the same cost and the same gradient, of a plain square.
#include <gtest/gtest.h>

#include <holdfast/solvers/detail/fold.hpp>

#include "tests/problems.hpp"

namespace holdfast::testing {
namespace {

TEST(MustFold, WhereNoFunctionOfTheNormIsTheLoss) {
  EXPECT_FALSE(must_fold(Huber{1}, 3));
  EXPECT_FALSE(must_fold(per_component(Huber{1}), 1));
  EXPECT_TRUE(must_fold(per_component(Huber{1}), 2));
  EXPECT_TRUE(must_fold(one_sided(Huber{1}), 1));
}

// Huber 1 at r = −3: ρ = 2·3 − 1 = 5, so r̃ = −√5; ρ' = 1/3, so dr̃/dr = ρ' r / r̃ = 1/√5.
TEST(Fold, IsTheRootOfTheLossWithTheSignOfTheResidual) {
  double r[] = {-3, 0.5}, J[] = {1, 0, 0, 2};
  fold(per_component(Huber{1}), 1, 2, 2, r, J);
  EXPECT_DOUBLE_EQ(r[0], -std::sqrt(5));
  EXPECT_DOUBLE_EQ(r[1], 0.5);
  EXPECT_DOUBLE_EQ(J[0], 1 / std::sqrt(5));
  EXPECT_DOUBLE_EQ(J[3], 2);
  EXPECT_EQ(J[1], 0);
  EXPECT_EQ(J[2], 0);
}

TEST(Fold, KeepsCostAndGradientUnderEveryLoss) {
  std::mt19937_64 rng(1);
  constexpr int m = 3, n = 4;
  for (Loss loss : every_loss(m)) {
    if (!loss.per_component) continue;
    for (const double size : {0.1, 1.0, 8.0}) {
      const double weight = uniform(rng, 0.1, 3);
      const Vector<m> r = random_vector<m>(rng, size);
      Eigen::Matrix<double, m, n> J;
      for (int c = 0; c < n; ++c) J.col(c) = random_vector<m>(rng);
      Vector<m> folded = r;
      Eigen::Matrix<double, m, n> J_folded = J;
      fold(loss, weight, m, n, folded.data(), J_folded.data());
      const ReferenceTerm term = reference_term(loss, weight, r);
      EXPECT_NEAR(0.5 * folded.squaredNorm(), term.cost, 1e-12 * (1 + term.cost)) << loss.str();
      const Eigen::VectorXd gradient = J.transpose() * term.weights.cwiseProduct(Eigen::VectorXd(r));
      EXPECT_LT((J_folded.transpose() * folded - gradient).norm(), 1e-9 * (1 + gradient.norm())) << loss.str();
    }
  }
}

// At 0 the slope of r̃ is √(w ρ'(0)).
TEST(Fold, HasASlopeAtZero) {
  double r[] = {0}, J[] = {2};
  fold(one_sided(StudentT{1}), 3, 1, 1, r, J);  // ρ'(0) = 2
  EXPECT_EQ(r[0], 0);
  EXPECT_DOUBLE_EQ(J[0], 2 * std::sqrt(6));
}

TEST(Fold, NeedsNoJacobian) {
  double r[] = {-3};
  fold(one_sided(Huber{1}), 4, 1, 5, r, nullptr);
  EXPECT_DOUBLE_EQ(r[0], -std::sqrt(20));
}

}  // namespace
}  // namespace holdfast::testing
