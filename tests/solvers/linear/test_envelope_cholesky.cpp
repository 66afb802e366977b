#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <holdfast/solvers/linear/internal/envelope_cholesky.hpp>
#include <random>

namespace holdfast::testing {
namespace {

/// A random positive definite matrix whose rows begin where `first` says.
Eigen::MatrixXd matrix_of(const std::vector<int>& first, std::mt19937_64& rng) {
  const int n = static_cast<int>(first.size());
  std::uniform_real_distribution<double> entry(-1, 1);
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
  for (int i = 0; i < n; ++i)
    for (int j = first[i]; j < i; ++j) A(i, j) = A(j, i) = entry(rng);
  A.diagonal() = A.cwiseAbs().rowwise().sum().array() + 0.1;
  return A;
}

void load(EnvelopeCholesky& cholesky, const std::vector<int>& first, const Eigen::MatrixXd& A) {
  cholesky.set_layout(first);
  for (int i = 0; i < cholesky.size(); ++i)
    for (int j = first[i]; j <= i; ++j) cholesky.matrix()[cholesky.place(i, j)] = A(i, j);
}

std::vector<std::vector<int>> layouts() {
  std::vector<int> diagonal, band, dense, ragged;
  std::mt19937_64 rng(5);
  for (int i = 0; i < 40; ++i) {
    diagonal.push_back(i);
    band.push_back(std::max(0, i - 3));
    dense.push_back(0);
    ragged.push_back(std::uniform_int_distribution<int>(0, i)(rng));
  }
  return {diagonal, band, dense, ragged, {0}};
}

TEST(EnvelopeCholesky, SolvesAsADenseFactorisationDoes) {
  std::mt19937_64 rng(6);
  EnvelopeCholesky cholesky;  // one object, layout after layout
  for (const std::vector<int>& first : layouts()) {
    const Eigen::MatrixXd A = matrix_of(first, rng);
    load(cholesky, first, A);
    const Eigen::VectorXd b = Eigen::VectorXd::Random(A.rows()), damping = Eigen::VectorXd::Random(A.rows()).cwiseAbs();
    ASSERT_TRUE(cholesky.factor({damping.data(), damping.data() + damping.size()}));
    std::vector<double> x(b.data(), b.data() + b.size());
    cholesky.solve(x);
    const Eigen::MatrixXd damped = A + Eigen::MatrixXd(damping.asDiagonal());
    const Eigen::VectorXd expected = damped.ldlt().solve(b);
    for (int i = 0; i < b.size(); ++i) EXPECT_NEAR(x[i], expected[i], 1e-12);
    EXPECT_EQ(cholesky.diagonal(0), A(0, 0));
  }
}

TEST(EnvelopeCholesky, RefusesWhatIsNotPositiveDefinite) {
  EnvelopeCholesky cholesky;
  const std::vector<int> first{0, 0, 1};
  Eigen::Matrix3d A;
  A << 1, 2, 0, 2, 1, 0, 0, 0, 1;
  load(cholesky, first, A);
  EXPECT_FALSE(cholesky.factor({0, 0, 0}));
  EXPECT_TRUE(cholesky.factor({2, 2, 0}));
  A(1, 0) = A(0, 1) = NAN;
  load(cholesky, first, A);
  EXPECT_FALSE(cholesky.factor({0, 0, 0}));
}

}  // namespace
}  // namespace holdfast::testing
