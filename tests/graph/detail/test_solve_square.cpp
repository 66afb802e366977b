// W x = r of reports and predictions: like Eigen where W has full rank, one of the solutions where it has not.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <holdfast/graph/detail/factor_type.hpp>
#include <random>

namespace holdfast {
namespace {

Eigen::VectorXd solved(const Eigen::MatrixXd& W, const Eigen::VectorXd& r) {
  Eigen::VectorXd x(r.size());
  detail::solve_square(static_cast<int>(r.size()), W.data(), r.data(), x.data());
  return x;
}

TEST(SolveSquare, OfFullRankHasTheOneSolution) {
  std::mt19937_64 rng(2);
  std::normal_distribution<double> normal;
  for (int n : {1, 3, 6, 16, 17, 30}) {
    const Eigen::MatrixXd W = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return normal(rng); });
    const Eigen::VectorXd x = Eigen::VectorXd::NullaryExpr(n, [&] { return normal(rng); });
    EXPECT_LT((solved(W, W * x) - x).norm(), 1e-10 * x.norm()) << n;
  }
}

TEST(SolveSquare, ExchangesRowsWhereItMust) {
  const Eigen::MatrixXd W = (Eigen::MatrixXd(2, 2) << 0, 2, 4, 0).finished();
  EXPECT_EQ(solved(W, Eigen::Vector2d(6, 20)), Eigen::Vector2d(5, 3));
}

TEST(SolveSquare, AComponentOfWhichWSaysNothingIsZero) {
  const Eigen::MatrixXd W = (Eigen::MatrixXd(3, 3) << 2, 0, 1, 0, 0, 0, 0, 0, 4).finished();
  EXPECT_EQ(solved(W, Eigen::Vector3d(5, 0, 4)), Eigen::Vector3d(2, 0, 1));
  const Eigen::MatrixXd first = (Eigen::MatrixXd(2, 2) << 0, 3, 0, 0).finished();  // the equation of x₁ stands in the row of x₀
  EXPECT_EQ(solved(first, Eigen::Vector2d(6, 0)), Eigen::Vector2d(0, 2));
}

TEST(SolveSquare, OfLowerRankIsASolution) {
  std::mt19937_64 rng(3);
  std::normal_distribution<double> normal;
  for (int rank = 1; rank < 6; ++rank) {
    const Eigen::MatrixXd rows = Eigen::MatrixXd::NullaryExpr(rank, 6, [&] { return normal(rng); });
    const Eigen::MatrixXd W = rows.transpose() * rows;
    const Eigen::VectorXd r = W * Eigen::VectorXd::NullaryExpr(6, [&] { return normal(rng); });
    const Eigen::VectorXd x = solved(W, r);
    EXPECT_LT((W * x - r).norm(), 1e-9 * r.norm()) << rank;
    EXPECT_LT(x.norm(), 1e6) << rank << ": rounding was taken for a pivot";
  }
}

}  // namespace
}  // namespace holdfast
